#include "tools/t4d/commands.h"

namespace t4d::tools {

void addConform(CLI::App& app, int& exitCode) {
  auto* conform = app.add_subcommand("conform", "Test backends, readers and writers of 4D meshes");
  conform->require_subcommand(1);
  conform->footer(
      "Examples:\n"
      "  t4d conform backends\n"
      "  t4d conform copy corpus\n"
      "  t4d conform reader --reader ./my-reader\n"
      "  t4d conform writer --writer ./my-writer\n"
      "`t4d conform VERB --help` lists the options.");
  addConformBackends(*conform, exitCode);
  addConformReader(*conform, exitCode);
  addConformWriter(*conform, exitCode);
  addConformCorpus(*conform, exitCode);
}

}  // namespace t4d::tools
