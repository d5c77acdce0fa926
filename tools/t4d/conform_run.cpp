#include "tools/t4d/conform_run.h"

#include <algorithm>
#include <thread>

#include <fmt/format.h>

#include "formats/output_file.h"
#include "tools/t4d/console.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

struct ConformRun {
  std::string program;
  std::vector<conformance::CaseReport> reports;
};

/// Describes a run of a reader or a writer, as `tested` says; ids begin as `cases` says.
void describeRun(Members& members, const ConformRun& run, const std::string& tested,
                 const std::string& cases) {
  using conformance::Outcome;
  members(tested.c_str(), run.program, "The command, as it was given.").notEmpty();
  members("corpus_version", conformance::kCorpusVersion, "Version of the corpus.")
      .pattern(kVersionPattern);
  const auto count = [&](const char* name, Outcome outcome, const char* meaning) {
    members(name, std::ranges::count(run.reports, outcome, &conformance::CaseReport::outcome),
            meaning)
        .atLeast(0);
  };
  count("passed", Outcome::Passed, "Number of cases that passed.");
  count(
      "failed", Outcome::Failed,
      "Cases where a reader accepted a file that it must refuse, refused one that it must accept, "
      "or gave a wrong answer; where a writer exited with 1, wrote no file, or one that breaks a "
      "rule, holds another mesh, or stores a part twice.");
  count(
      "crashed", Outcome::Crashed,
      "Cases where a signal ended the program, its exit code was neither 0 nor 1, or it broke the "
      "protocol of a serving reader.");
  count("timed_out", Outcome::TimedOut, "Cases where the program did not answer within --timeout.");
  count("skipped", Outcome::Skipped, "Cases that were excluded or not reached.");
  members("cases", run.reports, "The simplest first; damaged files last.",
          [&](Members& own, const conformance::CaseReport& test) {
            own("id", test.id,
                "Name of the corpus file, of the damage to a valid one, or what a writer must be "
                "able to store and the name of the mesh.")
                .pattern(("^(" + cases + ")/.").c_str());
            own("outcome", conformance::nameOf(test.outcome), "The outcome of its worst request.")
                .oneOf({"passed", "failed", "crashed", "timed_out", "skipped"});
            own("message", test.message,
                "What is wrong, or why it was skipped; empty if it passed.");
          });
}

}  // namespace

void addConformOptions(CLI::App& command, ConformArguments& arguments, const ConformHelp& help) {
  arguments.parallel = std::max(1U, std::thread::hardware_concurrency());
  command.add_option("--only", arguments.only, "Run only these cases: " + help.only)
      ->type_name("GLOB");
  command.add_option("--skip", arguments.skip, "Skip these cases")->type_name("GLOB");
  command
      .add_option(
          "--parallel", arguments.parallel,
          fmt::format("Concurrent {} processes (default: the number of processors)", help.tested))
      ->check(CLI::Range(1U, 1024U))
      ->type_name("N");
  command
      .add_option("--timeout", arguments.timeoutSeconds,
                  fmt::format("Timeout per {}, in seconds of processor time (default: {})",
                              help.timeout, arguments.timeoutSeconds))
      ->check(CLI::Range(0.01, 86400.0))
      ->type_name("SECONDS");
  command.add_option("--junit", arguments.junit, "Write the results as JUnit XML")
      ->check(outputFile({".xml"}))
      ->type_name("FILE");
  command.add_option("--keep", arguments.keep, help.keep)->type_name("DIR");
  command.add_flag("--first", arguments.first, "Stop at the first failure");
  command.add_flag("--verbose", arguments.verbose, "List all failed cases");
  addJsonOption(command, arguments.json, help.report, [tested = help.tested, cases = help.cases] {
    return Members::schemaOf<ConformRun>(
        [&](Members& members, const ConformRun& run) { describeRun(members, run, tested, cases); });
  });
}

int reportNoRun(const Error& error) {
  return error.code == ErrorCode::InvalidInput ? wrongUsage(error.text()) : report(error);
}

int reportRun(const std::string& tested, const std::string& program,
              const ConformArguments& arguments,
              const std::vector<conformance::CaseReport>& reports,
              const std::function<std::string(std::size_t most)>& text) {
  if (!arguments.junit.empty()) {
    const auto written = formats::writeOutputFile(
        arguments.junit, conformance::reportJunit(tested, program, reports));
    if (!written) return report(written.error());
  }
  constexpr std::size_t kShown = 20;
  if (arguments.json) {
    printJson(Members::valueOf(
        ConformRun{program, reports},
        [&](Members& members, const ConformRun& run) { describeRun(members, run, tested, ""); }));
  } else {
    printResult(text(arguments.verbose ? reports.size() : kShown));
  }
  return std::ranges::any_of(reports, &conformance::CaseReport::isWrong) ? kFailed : kDone;
}

}  // namespace t4d::tools
