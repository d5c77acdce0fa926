#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/edit/clip_time.h"
#include "t4d/formats/t4d/writer.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/t4d_output.h"
#include "tools/program/time_window.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct FilterArguments {
  std::string input;
  InputOptions only;
  std::string output;
  TimeWindow window;
  int compression = 3;
  bool json = false;
};

int run(const FilterArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
    return wrongUsage(*misuse);
  }
  if (const auto misuse = options.window.misuse()) return wrongUsage(*misuse);
  const auto begin = std::chrono::steady_clock::now();
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  const auto span = options.window.spanIn(*input);
  if (!span) return report(span.error());
  std::vector<std::string> notices;
  keepThoseWithin(*span, *input, notices);

  auto writer = formats::T4dWriter::create(options.output, metadataOf(*input, versionText()),
                                           {.compression = options.compression});
  if (!writer) return report(writer.error());
  edit::TimeClip all;
  std::uint64_t capCells = 0;
  ordered_json caps = ordered_json::array();
  {
    ProgressBar bar("filtering", verbs::slabCountOf(input->bodies), "slabs");
    for (std::size_t i = 0; i < input->bodies.size(); ++i) {
      const auto& [name, source] = input->bodies[i];
      const auto clip =
          edit::clipTime(*source, *span, writer->body(i), bar.part(source->slabCount()));
      if (!clip) {
        Error error = clip.error();
        if (error.where.empty()) {
          error.where = fmt::format("{}: body '{}'", input->name, name);
        }
        return report(error);
      }
      if (clip->cells == 0) {
        return report(Error{ErrorCode::InvalidInput,
                            fmt::format("body '{}' is empty between the times {} and {}; choose "
                                        "others, or other bodies by --body",
                                        name, span->begin, span->end),
                            input->name,
                            {}});
      }
      all.slabs += clip->slabs;
      all.cells += clip->cells;
      all.cutSlabs += clip->cutSlabs;
      for (const edit::RunEnd& end : clip->caps) {
        capCells += end.triangles;
        caps.push_back({{"body", name}, {"time", end.time}, {"triangles", end.triangles}});
      }
    }
  }
  const auto bytes = finishEdited(*writer, *input);
  if (!bytes) return report(bytes.error());
  printNotices(notices);

  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    printJson({{"bodies", input->bodies.size()},
               {"time_begin", span->begin},
               {"time_end", span->end},
               {"slabs", all.slabs},
               {"slabs_cut", all.cutSlabs},
               {"tetrahedra", all.cells + capCells},
               {"caps", caps},
               {"bytes", *bytes},
               {"seconds", seconds},
               {"peak_bytes", peakBytes()}});
  } else {
    print("{}: {}, time {} to {}\n", options.output,
          counted(input->bodies.size(), "body", "bodies"), span->begin, span->end);
    print("  {} of {}, of which {} were cut; closed by {} of {}\n",
          counted(all.cells + capCells, "tetrahedron", "tetrahedra"), counted(all.slabs, "slab"),
          all.cutSlabs, counted(caps.size(), "cap"),
          counted(capCells, "tetrahedron", "tetrahedra"));
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
  }
  return reportLosses(writer->losses());
}

}  // namespace

void addFilter(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("filter", "Keep some bodies of a 4D mesh, or part of its time");
  auto options = std::make_shared<FilterArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  options->window.addTo(*command);
  addT4dOutputOption(*command, options->output);
  addCompressionOption(*command, options->compression);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n"
      "  t4d filter bolt.t4d --from 2 --to 3 -o middle.t4d\n"
      "  t4d filter mechanism.t4d --body screw --body nut -o two.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
