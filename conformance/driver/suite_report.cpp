#include "conformance/driver/suite_report.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "conformance/corpus/corpus.h"
#include "conformance/driver/plain_text.h"

namespace t4d::conformance {
namespace {

constexpr std::array<Outcome, 5> kOutcomes = {Outcome::Passed, Outcome::Failed, Outcome::Crashed,
                                              Outcome::TimedOut, Outcome::Skipped};

std::size_t countOf(const OutcomeCounts& counts, Outcome outcome) {
  return counts[static_cast<std::size_t>(outcome)];
}

/// The cases of one kind.
struct Kind {
  std::string name;
  std::vector<std::size_t> cases;
};

std::vector<Kind> kindsOf(const std::vector<CaseReport>& cases) {
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

OutcomeCounts countsOf(const Kind& kind, const std::vector<CaseReport>& cases) {
  OutcomeCounts counts{};
  for (const std::size_t i : kind.cases) ++counts[static_cast<std::size_t>(cases[i].outcome)];
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

std::string junitCase(const CaseReport& test) {
  const std::string kind = kindOf(test.id);
  std::string xml =
      fmt::format("    <testcase classname=\"t4d.{}\" name=\"{}\" time=\"{:.3f}\"", escaped(kind),
                  escaped(test.id.substr(kind.size() + 1)), test.seconds);
  if (test.outcome == Outcome::Passed) return xml + "/>\n";
  const std::string message = escaped(test.message);
  xml += ">\n";
  if (test.outcome == Outcome::Skipped) {
    xml += fmt::format("      <skipped message=\"{}\"/>\n", message);
  } else {
    const char* element = test.outcome == Outcome::Failed ? "failure" : "error";
    xml += fmt::format("      <{0} type=\"{1}\" message=\"{2}\">{2}</{0}>\n", element,
                       nameOf(test.outcome), message);
  }
  return xml + "    </testcase>\n";
}

std::string table(const std::vector<CaseReport>& cases) {
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
  for (const Kind& kind : kindsOf(cases)) row(kind.name, countsOf(kind, cases));
  row("all", countsOf(cases));
  return text + "\n";
}

/// Why cases were skipped, one line for each reason.
std::string skippedFor(const std::vector<CaseReport>& cases) {
  std::map<std::string, std::size_t> counts;
  for (const CaseReport& test : cases) {
    if (test.outcome == Outcome::Skipped) ++counts[test.message];
  }
  std::string text;
  for (const auto& [reason, count] : counts) text += fmt::format("skipped {}: {}\n", count, reason);
  return text;
}

}  // namespace

OutcomeCounts countsOf(const std::vector<CaseReport>& cases) {
  OutcomeCounts counts{};
  for (const CaseReport& test : cases) ++counts[static_cast<std::size_t>(test.outcome)];
  return counts;
}

std::string kindOf(const std::string& id) { return id.substr(0, id.find('/')); }

std::string reportJunit(const std::string& tested, const std::string& command,
                        const std::vector<CaseReport>& cases) {
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  xml += fmt::format("<testsuites name=\"t4d conform {}: {}\" {}>\n", tested, escaped(command),
                     sums(countsOf(cases), cases.size()));
  for (const Kind& kind : kindsOf(cases)) {
    xml += fmt::format("  <testsuite name=\"{}\" {}>\n", escaped(kind.name),
                       sums(countsOf(kind, cases), kind.cases.size()));
    for (const std::size_t i : kind.cases) xml += junitCase(cases[i]);
    xml += "  </testsuite>\n";
  }
  return xml + "</testsuites>\n";
}

std::string outcomeTable(const std::vector<CaseReport>& cases) {
  return table(cases) + skippedFor(cases);
}

std::string failureText(const CaseReport& test, const std::string& about) {
  std::string name = nameOf(test.outcome);
  std::replace(name.begin(), name.end(), '_', ' ');
  return fmt::format("{} {}\n{}  {}\n", name, test.id,
                     about.empty() ? "" : fmt::format("  {}\n", about), test.message);
}

}  // namespace t4d::conformance
