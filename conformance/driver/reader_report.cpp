#include "conformance/driver/reader_report.h"

#include <algorithm>

#include <fmt/format.h>

namespace t4d::conformance {
namespace {

/// The commands that repeat a failed trial without this program.
std::string byHand(const std::string& reader, const std::string& command, bool serve,
                   const ReaderCase& test, const Trial& trial) {
  std::string request;
  for (const std::string& word : trial.request) request += " " + word;
  const std::string file = "corpus/" + keptFile(test, trial).string();
  std::string text;
  if (!isNone(trial.damage)) {
    text = fmt::format("  {} --only {} --keep corpus\n", command, test.id);
  } else {
    text = "  t4d conform copy corpus   # once\n";
  }
  text += serve ? fmt::format("  echo \"{} {}\" | {} --serve\n", request.substr(1), file, reader)
                : fmt::format("  {} {}{}; echo $?\n", reader, file, request);
  if (trial.answer.json.empty() || !isNone(trial.damage)) return text;
  return text + fmt::format("  The right answers are in corpus/{}.json.\n", test.id);
}

}  // namespace

std::vector<CaseReport> reportsOf(const std::vector<ReaderCase>& cases,
                                  const std::vector<ReaderResult>& results) {
  std::vector<CaseReport> reports;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    reports.push_back({cases[i].id, results[i].outcome, results[i].message, results[i].seconds});
  }
  return reports;
}

std::string reportText(const std::string& reader, const std::string& command, bool serve,
                       const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results, std::size_t most) {
  const std::vector<CaseReport> reports = reportsOf(cases, results);
  std::string text;
  std::size_t wrong = 0;
  std::size_t first = cases.size();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!reports[i].isWrong()) continue;
    if (first == cases.size()) first = i;
    if (++wrong > most) continue;
    // In other cases the message states the fault.
    const CorpusFile& file = *cases[i].file;
    const bool states = cases[i].id == file.id && file.validity != Validity::Invalid;
    text += failureText(reports[i], states ? file.fault : "");
  }
  if (wrong > most) text += fmt::format("and {} more (--verbose lists all)\n", wrong - most);
  if (wrong > 0) text += "\n";
  text += outcomeTable(reports);
  if (wrong == 0) {
    return text + fmt::format("{} of {} cases of corpus {} passed, none failed\n",
                              countsOf(reports)[static_cast<std::size_t>(Outcome::Passed)],
                              cases.size(), kCorpusVersion);
  }
  text += fmt::format("\nLook first at {}:\n", cases[first].id);
  return text +
         byHand(reader, command, serve, cases[first], cases[first].trials[results[first].wrong[0]]);
}

}  // namespace t4d::conformance
