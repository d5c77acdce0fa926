#include "t4d/conformance/driver/reader_report.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/conformance/driver/plain_text.h"

namespace t4d::conformance {
namespace {

using nlohmann::ordered_json;

constexpr std::array<Outcome, 5> kOutcomes = {Outcome::Passed, Outcome::Failed, Outcome::Crashed,
                                              Outcome::TimedOut, Outcome::Skipped};

std::size_t countOf(const OutcomeCounts& counts, Outcome outcome) {
  return counts[static_cast<std::size_t>(outcome)];
}

bool isWrong(const ReaderResult& result) {
  return result.outcome != Outcome::Passed && result.outcome != Outcome::Skipped;
}

/// The cases of one kind.
struct Kind {
  std::string name;
  std::vector<std::size_t> cases;
};

std::vector<Kind> kindsOf(const std::vector<ReaderCase>& cases) {
  std::vector<Kind> kinds;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string name = kindOf(cases[i].id);
    auto found = std::find_if(kinds.begin(), kinds.end(),
                              [&](const Kind& kind) { return kind.name == name; });
    if (found == kinds.end()) found = kinds.insert(kinds.end(), {name, {}});
    found->cases.push_back(i);
  }
  return kinds;
}

OutcomeCounts countsOf(const Kind& kind, const std::vector<ReaderResult>& results) {
  OutcomeCounts counts{};
  for (const std::size_t i : kind.cases) ++counts[static_cast<std::size_t>(results[i].outcome)];
  return counts;
}

std::string escaped(const std::string& text) {
  std::string xml;
  for (const char c : plain(text)) {
    switch (c) {
      case '&':
        xml += "&amp;";
        break;
      case '<':
        xml += "&lt;";
        break;
      case '>':
        xml += "&gt;";
        break;
      case '"':
        xml += "&quot;";
        break;
      default:
        xml += c;
    }
  }
  return xml;
}

std::string sums(const OutcomeCounts& counts, std::size_t all) {
  return fmt::format("tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\"", all,
                     countOf(counts, Outcome::Failed),
                     countOf(counts, Outcome::Crashed) + countOf(counts, Outcome::TimedOut),
                     countOf(counts, Outcome::Skipped));
}

std::string junitCase(const ReaderCase& test, const ReaderResult& result) {
  const std::string kind = kindOf(test.id);
  std::string xml =
      fmt::format("    <testcase classname=\"t4d.{}\" name=\"{}\" time=\"{:.3f}\"", escaped(kind),
                  escaped(test.id.substr(kind.size() + 1)), result.seconds);
  if (result.outcome == Outcome::Passed) return xml + "/>\n";
  const std::string message = escaped(result.message);
  xml += ">\n";
  if (result.outcome == Outcome::Skipped) {
    xml += fmt::format("      <skipped message=\"{}\"/>\n", message);
  } else {
    const char* element = result.outcome == Outcome::Failed ? "failure" : "error";
    xml += fmt::format("      <{0} type=\"{1}\" message=\"{2}\">{2}</{0}>\n", element,
                       nameOf(result.outcome), message);
  }
  return xml + "    </testcase>\n";
}

/// How to repeat a failed trial without this program.
std::string byHand(const std::string& reader, const std::string& command, bool serve,
                   const ReaderCase& test, const Trial& trial) {
  std::string request;
  for (const std::string& word : trial.request) request += " " + word;
  const std::string file = "corpus/" + keptFile(test, trial).string();
  std::string text;
  if (trial.damage) {
    text = fmt::format("  {} --only {} --keep corpus\n", command, test.id);
  } else {
    text = "  t4d conform copy corpus   # once\n";
  }
  text += serve ? fmt::format("  echo \"{} {}\" | {} --serve\n", request.substr(1), file, reader)
                : fmt::format("  {} {}{}; echo $?\n", reader, file, request);
  if (trial.answer.json.empty() || trial.damage) return text;
  return text + fmt::format("  The right answers are in corpus/{}.json.\n", test.id);
}

std::string table(const std::vector<Kind>& kinds, const std::vector<ReaderResult>& results) {
  std::string text = fmt::format("{:9}", "");
  for (const Outcome outcome : kOutcomes) {
    std::string name = nameOf(outcome);
    std::replace(name.begin(), name.end(), '_', ' ');
    text += fmt::format("{:>10}", name);
  }
  const auto row = [&](const std::string& name, const OutcomeCounts& counts) {
    text += fmt::format("\n{:9}", name);
    for (const Outcome outcome : kOutcomes) text += fmt::format("{:10}", countOf(counts, outcome));
  };
  for (const Kind& kind : kinds) row(kind.name, countsOf(kind, results));
  row("all", countsOf(results));
  return text + "\n";
}

/// Why cases were skipped, one line for each reason.
std::string skippedFor(const std::vector<ReaderResult>& results) {
  std::map<std::string, std::size_t> counts;
  for (const ReaderResult& result : results) {
    if (result.outcome == Outcome::Skipped) ++counts[result.message];
  }
  std::string text;
  for (const auto& [reason, count] : counts) text += fmt::format("skipped {}: {}\n", count, reason);
  return text;
}

}  // namespace

OutcomeCounts countsOf(const std::vector<ReaderResult>& results) {
  OutcomeCounts counts{};
  for (const ReaderResult& result : results) ++counts[static_cast<std::size_t>(result.outcome)];
  return counts;
}

std::string kindOf(const std::string& id) { return id.substr(0, id.find('/')); }

std::string reportJson(const std::string& reader, const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results) {
  ordered_json report = {{"reader", reader}, {"corpus_version", kCorpusVersion}};
  const OutcomeCounts counts = countsOf(results);
  for (const Outcome outcome : kOutcomes) report[nameOf(outcome)] = countOf(counts, outcome);
  report["cases"] = ordered_json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    report["cases"].push_back({{"id", cases[i].id},
                               {"outcome", nameOf(results[i].outcome)},
                               {"message", results[i].message}});
  }
  return report.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string reportJunit(const std::string& reader, const std::vector<ReaderCase>& cases,
                        const std::vector<ReaderResult>& results) {
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  xml += fmt::format("<testsuites name=\"t4d conform reader: {}\" {}>\n", escaped(reader),
                     sums(countsOf(results), results.size()));
  for (const Kind& kind : kindsOf(cases)) {
    xml += fmt::format("  <testsuite name=\"{}\" {}>\n", escaped(kind.name),
                       sums(countsOf(kind, results), kind.cases.size()));
    for (const std::size_t i : kind.cases) xml += junitCase(cases[i], results[i]);
    xml += "  </testsuite>\n";
  }
  return xml + "</testsuites>\n";
}

std::string reportText(const std::string& reader, const std::string& command, bool serve,
                       const std::vector<ReaderCase>& cases,
                       const std::vector<ReaderResult>& results, std::size_t most) {
  std::string text;
  std::size_t wrong = 0;
  std::size_t first = cases.size();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!isWrong(results[i])) continue;
    if (first == cases.size()) first = i;
    if (++wrong > most) continue;
    std::string name = nameOf(results[i].outcome);
    std::replace(name.begin(), name.end(), '_', ' ');
    text += fmt::format("{} {}\n", name, cases[i].id);
    // In other cases the message states the fault.
    const CorpusFile& file = *cases[i].file;
    if (cases[i].id == file.id && file.validity != Validity::Invalid) {
      text += fmt::format("  {}\n", file.fault);
    }
    text += fmt::format("  {}\n", results[i].message);
  }
  if (wrong > most) text += fmt::format("and {} more (--verbose lists all)\n", wrong - most);
  if (wrong > 0) text += "\n";
  text += table(kindsOf(cases), results) + skippedFor(results);
  if (wrong == 0) {
    return text + fmt::format("{} of {} cases of corpus {} passed, none failed\n",
                              countOf(countsOf(results), Outcome::Passed), cases.size(),
                              kCorpusVersion);
  }
  text += fmt::format("\nLook first at {}:\n", cases[first].id);
  return text +
         byHand(reader, command, serve, cases[first], cases[first].trials[results[first].wrong[0]]);
}

}  // namespace t4d::conformance
