#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/time_window.h"
#include "tools/t4d/version.h"
#include "tools/verbs/filter.h"

namespace t4d::tools {
namespace {

constexpr std::uint64_t kMostTracks = 0xFFFFFFFF;

struct FilterArguments {
  std::string input;
  InputOptions only;
  TimeWindow window;
  verbs::FilterOptions filter;
  bool json = false;
};

void printReport(const verbs::FilterReport& filtered, const std::string& output) {
  print("{}: {}, time {} to {}\n", output, counted(filtered.bodies, "body", "bodies"),
        filtered.span.begin, filtered.span.end);
  print("  {} of {}, of which {} were cut; closed by {} of {}\n",
        counted(filtered.cells, "tetrahedron", "tetrahedra"), counted(filtered.slabs, "slab"),
        filtered.slabsCut, counted(filtered.caps.size(), "cap"),
        counted(filtered.capCells(), "tetrahedron", "tetrahedra"));
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(filtered.bytes), filtered.seconds,
        sizeText(peakBytes()));
}

int run(FilterArguments& options) {
  const std::string& output = options.filter.output;
  if (const auto misuse = options.window.misuse()) return wrongUsage(*misuse);
  if (options.filter.track && (!options.window.isWhole())) {
    return wrongUsage("--track excludes --from and --to: a track has its own time");
  }
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  options.filter.window = options.window;
  options.filter.generator = versionText();
  ConsoleObserver observer;
  const auto filtered = verbs::filter(*input, options.filter, observer);
  if (!filtered) {
    Error error = filtered.error();
    if (error.remedy == Remedy::OtherBodies) error.message += " by --body";
    return report(error);
  }
  printNotices(filtered->notices);
  if (options.json) {
    printAsJson(*filtered);
  } else {
    printReport(*filtered, output);
  }
  return reportLosses(filtered->losses);
}

}  // namespace

void addFilter(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("filter", "Keep some bodies of a 4D mesh, part of its time, or a track");
  auto options = std::make_shared<FilterArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  options->window.addTo(*command);
  command
      ->add_option("--track", options->filter.track,
                   "Keep this track alone, by its id (t4d track), closed where it begins and ends")
      ->check(CLI::Range(std::uint64_t{1}, kMostTracks))
      ->type_name("ID");
  addT4dOutputOption(*command, options->filter.output);
  addCompressionOption(*command, options->filter.compression);
  addJsonOption<verbs::FilterReport>(
      *command, options->json,
      "The part of a 4D mesh that was kept, and the file that was written.");
  command->footer(
      "Examples:\n"
      "  t4d filter bolt.t4d --from 2 --to 3 -o middle.t4d\n"
      "  t4d filter mechanism.t4d --body screw --body nut -o two.t4d\n"
      "  t4d filter cells.t4d --track 7 -o seven.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
