#include "tools/t4d/conform_run.h"

#include <algorithm>
#include <thread>

#include <fmt/format.h>

#include "formats/output_file.h"
#include "tools/t4d/console.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {

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
  command.add_flag("--json", arguments.json, "Print JSON");
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
  printResult(arguments.json ? conformance::reportJson(tested, program, reports)
                             : text(arguments.verbose ? reports.size() : kShown));
  return std::ranges::any_of(reports, &conformance::CaseReport::isWrong) ? kFailed : kDone;
}

}  // namespace t4d::tools
