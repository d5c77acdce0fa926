#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/measure/diff.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_bodies.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {
namespace {

struct DiffArguments {
  std::string a;
  std::string b;
  measure::DiffOptions how;
  bool json = false;
};

const char* levelName(measure::SameLevel level) {
  switch (level) {
    case measure::SameLevel::Bytes:
      return "bytes";
    case measure::SameLevel::Mesh:
      return "mesh";
    case measure::SameLevel::Solid:
      return "solid";
    case measure::SameLevel::Different:
      break;
  }
  return "different";
}

const char* levelText(measure::SameLevel level) {
  switch (level) {
    case measure::SameLevel::Bytes:
      return "the same bytes";
    case measure::SameLevel::Mesh:
      return "the same mesh, stored otherwise";
    case measure::SameLevel::Solid:
      return "the same solid, within the tolerance";
    case measure::SameLevel::Different:
      break;
  }
  return "different";
}

int run(const DiffArguments& options) {
  Result<measure::Diff> diff;
  {
    ProgressBar bar("comparing");
    diff = measure::diffT4d(options.a, options.b, options.how, bar.callback());
  }
  if (!diff) return report(diff.error());
  const bool same = diff->level != measure::SameLevel::Different;
  if (options.json) {
    printJson({{"same", same}, {"level", levelName(diff->level)}, {"messages", diff->messages}});
  } else {
    print("{} and {}: {}\n", options.a, options.b, levelText(diff->level));
    for (const std::string& message : diff->messages) print("  {}\n", message);
  }
  return same ? kDone : kFailed;
}

}  // namespace

void addDiff(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "diff", "Say whether two .t4d files have the same bytes, the same mesh or the same solid");
  auto options = std::make_shared<DiffArguments>();
  command->add_option("A", options->a, kT4dFileHelp)->required();
  command->add_option("B", options->b, "The other .t4d file")->required();
  command
      ->add_option("--tolerance", options->how.tolerance,
                   "How far the surfaces of the same solid may be apart (default: a thousandth of "
                   "the diagonal of both)")
      ->type_name("LENGTH")
      ->check(CLI::NonNegativeNumber)
      ->check(finiteNumber());
  command
      ->add_option("--slices", options->how.times,
                   "At how many times solids are compared, besides the first and the last")
      ->type_name("N")
      ->check(wholeNumber(1, 100'000))
      ->capture_default_str();
  addMaxCellsOption(*command, options->how.maxCells);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Exit codes: 0 the same, 1 different.\n"
      "Example:\n  t4d diff bolt.t4d again.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
