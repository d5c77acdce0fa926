#include <algorithm>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/conformance/driver/reader_report.h"
#include "tools/program/commands.h"
#include "tools/program/conform_run.h"
#include "tools/program/console.h"

namespace t4d::tools {
namespace {

using namespace conformance;

struct ConformReaderArguments {
  std::string reader;
  std::vector<std::string> only;
  std::vector<std::string> skip;
  CaseOptions cases;
  bool serve = false;
  unsigned parallel = std::max(1U, std::thread::hardware_concurrency());
  double timeoutSeconds = 10;
  std::string junit;
  std::string keep;
  bool first = false;
  bool json = false;
  bool verbose = false;
};

/// The command that reruns the same cases.
std::string commandOf(const ConformReaderArguments& options) {
  std::string command = fmt::format("t4d conform reader --reader '{}'", options.reader);
  for (const std::string& feature : options.cases.without) command += " --without " + feature;
  if (options.serve) command += " --serve";
  if (options.cases.quick) command += " --quick";
  return command + (options.cases.thorough ? " --thorough" : "");
}

int run(const ConformReaderArguments& options) {
  const auto command = system::splitCommand(options.reader);
  if (!command) return wrongUsage(command.error().text());
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files, options.cases);
  if (auto done = selectCases(cases, options.only, options.skip); !done) {
    return wrongUsage(done.error().text() + "; `t4d conform list` lists them");
  }
  disableCoreDumps();
  Result<std::vector<ReaderResult>> results;
  {
    const Interruptible interruptible;
    ProgressBar bar("testing the reader");
    const SuiteOptions suite = {*command,         options.serve, options.timeoutSeconds,
                                options.parallel, options.first, &Interruptible::interrupted()};
    results = runReaderCases(cases, suite, bar.callback());
  }
  if (!results) {
    return results.error().code == ErrorCode::InvalidInput ? wrongUsage(results.error().text())
                                                           : report(results.error());
  }
  Interruptible::endIfInterrupted();
  const std::vector<CaseReport> reports = reportsOf(cases, *results);
  if (!options.junit.empty()) {
    const auto written = writeReport(options.junit, reportJunit("reader", options.reader, reports));
    if (!written) return report(written.error());
  }
  if (!options.keep.empty()) {
    const auto kept = keepWrongFiles(cases, *results, options.keep);
    if (!kept) return report(kept.error());
    if (*kept > 0) say(fmt::format("{} in {}", counted(*kept, "file"), options.keep));
  }
  if (options.json) {
    print("{}", reportJson("reader", options.reader, reports));
  } else {
    constexpr std::size_t kShown = 20;
    print("{}", reportText(options.reader, commandOf(options), options.serve, cases, *results,
                           options.verbose ? cases.size() : kShown));
  }
  return std::ranges::any_of(reports, &CaseReport::isWrong) ? kFailed : kDone;
}

}  // namespace

void addConformReader(CLI::App& conform, int& exitCode) {
  auto* command = conform.add_subcommand(
      "reader", "Run a reader against the corpus, and against files damaged on the spot");
  auto options = std::make_shared<ConformReaderArguments>();
  command
      ->add_option(
          "--reader", options->reader,
          "The program, run as READER FILE describe, READER FILE slice T and so on (the appendix "
          "of SPEC.md); may have arguments: 'python3 my_reader.py'")
      ->required()
      ->type_name("READER");
  command->add_flag("--serve", options->serve,
                    "Run READER --serve once, and send it one request a line: much faster if it "
                    "is slow to start");
  command->add_option("--only", options->only, "Run only these cases: globs or folders ('cut')")
      ->type_name("GLOB");
  command->add_option("--skip", options->skip, "Skip these cases")->type_name("GLOB");
  command
      ->add_option("--without", options->cases.without,
                   "A feature that the reader does not support, and must refuse files for (zstd, "
                   "means, pose, grid), or 'hyperplanes' if it slices at times only")
      ->delimiter(',')
      ->check(CLI::IsMember(whatAReaderMayLack()))
      ->type_name("FEATURE");
  command
      ->add_option("--parallel", options->parallel,
                   "Concurrent reader processes (default: the number of processors)")
      ->check(CLI::Range(1U, 1024U))
      ->type_name("N");
  command
      ->add_option("--timeout", options->timeoutSeconds,
                   "Timeout per request, in seconds (default: 10)")
      ->check(CLI::Range(0.01, 86400.0))
      ->type_name("SECONDS");
  command->add_option("--junit", options->junit, "Write the results as JUnit XML")
      ->type_name("FILE");
  command->add_option("--keep", options->keep, "Keep up to four files of each failed case in DIR")
      ->type_name("DIR");
  auto* thorough = command->add_flag(
      "--thorough", options->cases.thorough,
      "Ten times as many damaged files, for a reader that is fast to start or serves");
  command
      ->add_flag("--quick", options->cases.quick,
                 "A selection of some 170 requests, with a file for every rule")
      ->excludes(thorough);
  command->add_flag("--first", options->first, "Stop at the first failure");
  command->add_flag("--verbose", options->verbose, "List all failed cases");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Exits with 0 if every case passed, 1 if any failed.\n"
      "Examples:\n"
      "  t4d conform reader --reader ./my-reader\n"
      "  t4d conform reader --reader 'node my_reader.mjs' --serve\n"
      "  t4d conform reader --reader 'python3 my_reader.py' --without zstd --only valid");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
