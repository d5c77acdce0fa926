#include <fmt/format.h>

#include "conformance/driver/reader_report.h"
#include "formats/output_folder.h"
#include "platform/process.h"
#include "platform/signals.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/conform_run.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

using namespace conformance;

struct ConformReaderArguments {
  std::string reader;
  CaseOptions cases;
  bool serve = false;
  ConformArguments run = {.timeoutSeconds = 10};
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
  const ConformArguments& run = options.run;
  const auto command = platform::splitCommand(options.reader);
  if (!command) return wrongUsage(command.error().text());
  const std::vector<CorpusFile> files = makeCorpus();
  std::vector<ReaderCase> cases = readerCases(files, options.cases);
  if (auto done = selectCases(cases, run.only, run.skip); !done) {
    return wrongUsage(done.error().text() + "; `t4d conform list` lists them");
  }
  if (!run.keep.empty()) {
    if (auto made = formats::makeKeptFolder(run.keep); !made) return report(made.error());
  }
  platform::disableCoreDumps();
  Result<std::vector<ReaderResult>> results;
  {
    const platform::Interruptible interruptible;
    ProgressBar bar("testing the reader");
    const SuiteOptions suite = {*command,           options.serve,
                                run.timeoutSeconds, run.parallel,
                                run.first,          &platform::Interruptible::interrupted()};
    results = runReaderCases(cases, suite, bar.callback());
  }
  if (!results) return reportNoRun(results.error());
  platform::Interruptible::endIfInterrupted();
  if (!run.keep.empty()) {
    const auto kept = keepWrongFiles(cases, *results, run.keep);
    if (!kept) return report(kept.error());
    if (*kept > 0) say(fmt::format("{} in {}", counted(*kept, "file"), run.keep));
  }
  return reportRun("reader", options.reader, run, reportsOf(cases, *results), [&](auto most) {
    return reportText(options.reader, commandOf(options), options.serve, cases, *results, most);
  });
}

}  // namespace

void addConformReader(CLI::App& conform, int& exitCode) {
  auto* command =
      conform.add_subcommand("reader", "Run a reader against the corpus and damaged files");
  auto options = std::make_shared<ConformReaderArguments>();
  command
      ->add_option("--reader", options->reader,
                   "Reader command, such as 'python3 my_reader.py' (docs/conform.md)")
      ->required()
      ->type_name("READER");
  command->add_flag("--serve", options->serve,
                    "Start READER --serve once per process and send it one request per line");
  command
      ->add_option("--without", options->cases.without,
                   "Feature that the reader does not support (docs/conform.md)")
      ->delimiter(',')
      ->check(CLI::IsMember(whatAReaderMayLack()))
      ->type_name("FEATURE");
  auto* thorough = command->add_flag("--thorough", options->cases.thorough,
                                     "Test ten times as many damaged files");
  command
      ->add_flag("--quick", options->cases.quick,
                 "Run only some 170 requests, with a file for every rule")
      ->excludes(thorough);
  addConformOptions(*command, options->run,
                    {.tested = "reader",
                     .only = "globs or folders ('cut')",
                     .timeout = "request",
                     .keep = "Keep up to four files of each failed case in DIR",
                     .cases = "valid|impl|invalid|cut|flip|overwrite",
                     .report = "Results of a reader of .t4d."});
  command->footer(
      "Exits with 0 if every case passed, 1 if any failed.\n"
      "Examples:\n"
      "  t4d conform reader --reader ./my-reader\n"
      "  t4d conform reader --reader 'node my_reader.mjs' --serve\n"
      "  t4d conform reader --reader 'python3 my_reader.py' --without zstd --only valid");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
