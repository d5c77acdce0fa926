#include <algorithm>
#include <thread>

#include <fmt/format.h>

#include "t4d/conformance/driver/case_choice.h"
#include "t4d/conformance/driver/writer_suite.h"
#include "tools/program/commands.h"
#include "tools/program/conform_run.h"
#include "tools/program/console.h"

namespace t4d::tools {
namespace {

using namespace conformance;

struct ConformWriterArguments {
  std::string writer;
  std::vector<std::string> only;
  std::vector<std::string> skip;
  unsigned parallel = std::max(1U, std::thread::hardware_concurrency());
  double timeoutSeconds = 60;
  std::string junit;
  std::string keep;
  bool first = false;
  bool json = false;
  bool verbose = false;
};

int run(const ConformWriterArguments& options) {
  const auto command = system::splitCommand(options.writer);
  if (!command) return wrongUsage(command.error().text());
  std::vector<WriterCase> cases = writerCases();
  if (auto done = selectCases(cases, options.only, options.skip); !done) {
    return wrongUsage(done.error().text());
  }
  disableCoreDumps();
  Result<std::vector<CaseReport>> reports;
  {
    const Interruptible interruptible;
    ProgressBar bar("testing the writer");
    const WriterOptions suite = {*command,         options.timeoutSeconds,
                                 options.parallel, options.first,
                                 options.keep,     &Interruptible::interrupted()};
    reports = runWriterCases(cases, suite, bar.callback());
  }
  if (!reports) {
    return reports.error().code == ErrorCode::InvalidInput ? wrongUsage(reports.error().text())
                                                           : report(reports.error());
  }
  Interruptible::endIfInterrupted();
  if (!options.junit.empty()) {
    const auto written =
        writeReport(options.junit, reportJunit("writer", options.writer, *reports));
    if (!written) return report(written.error());
  }
  if (options.json) {
    print("{}", reportJson("writer", options.writer, *reports));
  } else {
    constexpr std::size_t kShown = 20;
    print("{}", writerReportText(options.writer,
                                 fmt::format("t4d conform writer --writer '{}'", options.writer),
                                 cases, *reports, options.verbose ? cases.size() : kShown));
  }
  return std::ranges::any_of(*reports, &CaseReport::isWrong) ? kFailed : kDone;
}

}  // namespace

void addConformWriter(CLI::App& conform, int& exitCode) {
  auto* command = conform.add_subcommand(
      "writer", "Run a writer on meshes, and judge the .t4d files that it makes");
  auto options = std::make_shared<ConformWriterArguments>();
  command
      ->add_option("--writer", options->writer,
                   "The program, run as WRITER MESH.json OUT.t4d (docs/conform.md); may have "
                   "arguments: 'python3 my_writer.py'")
      ->required()
      ->type_name("WRITER");
  command
      ->add_option("--only", options->only,
                   "Run only these cases: globs or kinds (plain, means, attributes, bodies, head)")
      ->type_name("GLOB");
  command->add_option("--skip", options->skip, "Skip these cases")->type_name("GLOB");
  command
      ->add_option("--parallel", options->parallel,
                   "Concurrent writer processes (default: the number of processors)")
      ->check(CLI::Range(1U, 1024U))
      ->type_name("N");
  command
      ->add_option("--timeout", options->timeoutSeconds,
                   "Timeout per case, in seconds (default: 60)")
      ->check(CLI::Range(0.01, 86400.0))
      ->type_name("SECONDS");
  command->add_option("--junit", options->junit, "Write the results as JUnit XML")
      ->type_name("FILE");
  command
      ->add_option("--keep", options->keep, "Keep the mesh and the file of each failed case in DIR")
      ->type_name("DIR");
  command->add_flag("--first", options->first, "Stop at the first failure");
  command->add_flag("--verbose", options->verbose, "List all failed cases");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Exits with 0 if every case passed, 1 if any failed.\n"
      "Examples:\n"
      "  t4d conform writer --writer ./my-writer\n"
      "  t4d conform writer --writer 'python3 my_writer.py' --only plain --keep failed");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
