#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/verbs/diff.h"

namespace t4d::tools {
namespace {

struct DiffArguments {
  std::string a;
  std::string b;
  verbs::DiffOptions how;
  bool json = false;
};

const char* levelText(verbs::SameLevel level) {
  switch (level) {
    case verbs::SameLevel::Bytes:
      return "the same bytes";
    case verbs::SameLevel::Mesh:
      return "the same mesh, stored otherwise";
    case verbs::SameLevel::Solid:
      return "the same solid, within the tolerance";
    case verbs::SameLevel::Different:
      break;
  }
  return "different";
}

int run(const DiffArguments& options) {
  Result<verbs::Diff> diff;
  {
    ProgressBar bar("comparing");
    diff = verbs::diff(options.a, options.b, options.how, bar.callback());
  }
  if (!diff) return report(diff.error());
  const bool same = diff->level != verbs::SameLevel::Different;
  if (options.json) {
    printAsJson(*diff);
  } else {
    print("{} and {}: {}\n", options.a, options.b, levelText(diff->level));
    for (const std::string& message : diff->messages) print("  {}\n", message);
  }
  return same ? kDone : kFailed;
}

}  // namespace

void addDiff(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("diff", "Check whether two .t4d files have the same bytes, mesh or solid");
  auto options = std::make_shared<DiffArguments>();
  command->add_option("A", options->a, kT4dFileHelp)->required();
  command->add_option("B", options->b, "Other file (.t4d): path or URL")->required();
  command
      ->add_option(
          "--tolerance", options->how.tolerance,
          "Maximum distance between equal solids (default: 0.001 of their common diagonal)")
      ->type_name("LENGTH")
      ->check(CLI::NonNegativeNumber)
      ->check(finiteNumber());
  command
      ->add_option("--slices", options->how.times,
                   "Number of times to compare, besides the first and the last")
      ->type_name("N")
      ->check(wholeNumber(1, 100'000))
      ->capture_default_str();
  addMaxCellsOption(*command, options->how.maxCells);
  addJsonOption<verbs::Diff>(*command, options->json, "The level at which two .t4d files agree.");
  command->footer(
      "Exit codes: 0 the same, 1 different.\n"
      "Example:\n  t4d diff bolt.t4d again.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
