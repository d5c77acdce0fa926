#include "tools/t4d/filter.h"

#include <fmt/format.h>

#include "edit/clip_time.h"
#include "edit/cut_track.h"
#include "platform/stopwatch.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/time_window.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

Result<void> filterBodies(const Input& input, formats::T4dWriter& writer, FilterReport& report,
                          Observer& observer) {
  const auto stage = observer.stage("filtering", slabCountOf(input.bodies), "slabs");
  for (std::size_t i = 0; i < input.bodies.size(); ++i) {
    const auto& [name, source] = input.bodies[i];
    const auto clip =
        edit::clipTime(*source, report.span, writer.body(i), stage->part(source->slabCount()));
    if (!clip) {
      Error error = clip.error();
      if (error.where.empty()) error.where = placeIn(input.name, fmt::format("body '{}'", name));
      return error;
    }
    if (clip->cells == 0) {
      return invalid(fmt::format("body '{}' is empty between the times {} and {}; choose others, "
                                 "or other bodies",
                                 name, report.span.begin, report.span.end),
                     input.name, Remedy::OtherBodies);
    }
    report.slabs += clip->slabs;
    report.slabsCut += clip->cutSlabs;
    report.cells += clip->cells;
    for (const edit::RunEnd& end : clip->caps) {
      report.caps.push_back({name, end.time, end.triangles, end.cells});
    }
  }
  report.cells += report.capCells();
  return {};
}

/// A track by its number in a body.
struct TrackOfBody {
  std::size_t body = 0;
  std::uint32_t track = 0;
};

/// Finds the body of a track. Ids go on from body to body.
Result<TrackOfBody> bodyOfTrack(const Input& input, std::uint64_t id, Observer& observer) {
  if (input.bodies.size() == 1) return TrackOfBody{0, static_cast<std::uint32_t>(id - 1)};
  const auto stage = observer.stage("tracking", slabCountOf(input.bodies), "slabs");
  std::uint64_t before = 0;
  for (std::size_t b = 0; b < input.bodies.size(); ++b) {
    const model::Source& source = *input.bodies[b].source;
    const auto tracks =
        measure::tracksOf(source, {.times = {}, .layers = false}, stage->part(source.slabCount()));
    if (!tracks) return tracks.error();
    if (id <= before + tracks->tracks.size()) {
      return TrackOfBody{b, static_cast<std::uint32_t>(id - before - 1)};
    }
    before += tracks->tracks.size();
  }
  return invalid(fmt::format("has no track {}; it has {}", id, before));
}

Result<void> filterTrack(const Input& input, std::uint32_t track, formats::T4dWriter& writer,
                         FilterReport& report, Observer& observer) {
  const auto& [name, source] = input.bodies.front();
  const auto stage = observer.stage("filtering", source->slabCount(), "slabs");
  const auto cut = edit::cutTrack(*source, track, writer.body(0), stage->part(source->slabCount()));
  if (!cut) return cut.error();
  report.span = cut->span;
  report.slabs = cut->slabs;
  report.slabsCut = cut->cutSlabs;
  for (const edit::RunEnd& end : cut->caps) {
    report.caps.push_back({name, end.time, end.triangles, end.cells});
  }
  report.cells = cut->cells + report.capCells();
  return {};
}

}  // namespace

std::uint64_t FilterReport::capCells() const {
  std::uint64_t sum = 0;
  for (const FilterCap& cap : caps) sum += cap.cells;
  return sum;
}

Result<FilterReport> filter(const Input& input, const FilterOptions& options, Observer& observer) {
  const platform::Stopwatch stopwatch;
  FilterReport report;
  Input kept = input;
  std::uint32_t track = 0;
  if (options.track) {
    const auto found = bodyOfTrack(input, *options.track, observer);
    if (!found) return inInput(found.error(), input);
    track = found->track;
    kept.bodies = {input.bodies[found->body]};
  } else {
    const auto span = options.window.spanIn(input);
    if (!span) return span.error();
    report.span = *span;
    keepThoseWithin(*span, kept, report.notices);
  }
  report.bodies = kept.bodies.size();
  auto writer = formats::T4dWriter::create(options.output, metadataOf(kept, options.generator),
                                           {.compression = options.compression});
  if (!writer) return writer.error();
  const auto done = options.track ? filterTrack(kept, track, *writer, report, observer)
                                  : filterBodies(kept, *writer, report, observer);
  if (!done) return inInput(done.error(), input);
  const auto bytes = finishEdited(*writer, kept);
  if (!bytes) return bytes.error();
  report.bytes = *bytes;
  report.losses = writer->losses();
  report.seconds = stopwatch.seconds();
  return report;
}

void describe(Members& members, const FilterReport& report) {
  members("bodies", report.bodies, "Bodies written.").atLeast(1);
  members("time_begin", report.span.begin,
          "The first requested time, or that of the mesh, in its time unit.");
  members("time_end", report.span.end,
          "The last requested time, or that of the mesh, in its time unit.");
  members("slabs", report.slabs, "Slabs kept, whole or in part; caps are not counted.");
  members("slabs_cut", report.slabsCut, "Slabs that were cut at the first or last time.");
  members("tetrahedra", report.cells, "Tetrahedra written, including caps.");
  members("caps", report.caps, "The layers that were closed by a cap.",
          [](Members& own, const FilterCap& cap) {
            own("body", cap.body, "Name of the body.");
            own("time", cap.time, "Time of the layer.");
            own("triangles", cap.triangles,
                "Triangles that the cap closes, each with one tetrahedron.");
          });
  members("bytes", report.bytes, "Size of the file, in bytes.");
  addCosts(members, report.seconds);
}

namespace {

constexpr std::uint64_t kMostTracks = 0xFFFFFFFF;

struct FilterArguments {
  std::string input;
  InputOptions only;
  TimeWindow window;
  FilterOptions filter;
  bool json = false;
};

void printReport(const FilterReport& filtered, const std::string& output) {
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
  if (options.filter.track && (!options.window.isWhole())) {
    return wrongUsage("--track excludes --from and --to: a track has its own time");
  }
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  options.filter.window = options.window;
  options.filter.generator = versionText();
  ConsoleObserver observer;
  const auto filtered = filter(*input, options.filter, observer);
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
  addJsonOption<FilterReport>(
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
