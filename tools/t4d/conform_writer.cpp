#include <fmt/format.h>

#include "conformance/driver/case_choice.h"
#include "conformance/driver/writer_suite.h"
#include "formats/output_folder.h"
#include "platform/process.h"
#include "platform/signals.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/conform_run.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

using namespace conformance;

struct ConformWriterArguments {
  std::string writer;
  ConformArguments run = {.timeoutSeconds = 60};
};

int run(const ConformWriterArguments& options) {
  const ConformArguments& run = options.run;
  const auto command = platform::splitCommand(options.writer);
  if (!command) return wrongUsage(command.error().text());
  std::vector<WriterCase> cases = writerCases();
  if (auto done = selectCases(cases, run.only, run.skip); !done) {
    return wrongUsage(done.error().text());
  }
  if (!run.keep.empty()) {
    if (auto made = formats::makeKeptFolder(run.keep); !made) return report(made.error());
  }
  platform::disableCoreDumps();
  Result<std::vector<CaseReport>> reports;
  {
    const platform::Interruptible interruptible;
    ProgressBar bar("testing the writer");
    const WriterOptions suite = {*command,     run.timeoutSeconds,
                                 run.parallel, run.first,
                                 run.keep,     &platform::Interruptible::interrupted()};
    reports = runWriterCases(cases, suite, bar.callback());
  }
  if (!reports) return reportNoRun(reports.error());
  platform::Interruptible::endIfInterrupted();
  return reportRun("writer", options.writer, run, *reports, [&](auto most) {
    return writerReportText(options.writer,
                            fmt::format("t4d conform writer --writer '{}'", options.writer), cases,
                            *reports, most);
  });
}

}  // namespace

void addConformWriter(CLI::App& conform, int& exitCode) {
  auto* command = conform.add_subcommand(
      "writer", "Run a writer on meshes and check the .t4d files that it writes");
  auto options = std::make_shared<ConformWriterArguments>();
  command
      ->add_option("--writer", options->writer,
                   "Writer command, run as WRITER MESH.json OUT.t4d (docs/conform.md)")
      ->required()
      ->type_name("WRITER");
  addConformOptions(*command, options->run,
                    {.tested = "writer",
                     .only = "globs or kinds (plain, means, attributes, bodies, head)",
                     .timeout = "case",
                     .keep = "Keep the mesh and the file of each failed case in DIR",
                     .cases = "plain|means|attributes|bodies|head",
                     .report = "Results of a writer of .t4d."});
  command->footer(
      "Exits with 0 if every case passed, 1 if any failed.\n"
      "Examples:\n"
      "  t4d conform writer --writer ./my-writer\n"
      "  t4d conform writer --writer 'python3 my_writer.py' --only plain --keep failed");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
