#include "tools/verbs/mill.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "tools/verbs/members.h"
#include "tools/verbs/weave_names.h"

namespace t4d::verbs {
namespace {

using nlohmann::ordered_json;

/// The error, at the file that it is about.
Error atMillFile(Error error, const MillFiles& files) {
  if (error.where.empty() && error.remedy == Remedy::Motion) error.where = files.path;
  if (error.where.empty() || error.where == "stock") error.where = files.stock.path;
  if (const auto given = givenAs(error.where.file, files.tools)) error.where = *given;
  return error;
}

/// How the file was made, for its metadata.
std::string millDetails(const MillFiles& files, const MillOptions& options, std::size_t frames) {
  const auto fileName = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  ordered_json source{{"mesh", files.box.empty() ? fileName(files.stock.path) : files.box}};
  for (const auto& [number, spec] : files.tools) {
    const std::string tool = spec.files().empty() ? spec.tool : fileName(spec.tool);
    if (number == 0) {
      source["tool"] = tool;
    } else {
      source["tools"][std::to_string(number)] = tool;
    }
  }
  source[files.kind == ToolPathKind::Motion ? "motion" : "path"] = fileName(files.path);
  return ordered_json{{"source", source},
                      {"parameters",
                       {{"voxel_size", options.voxelSize},
                        {"frames", frames},
                        {"tolerance", options.toleranceOr()},
                        {"caps", nameOfCaps(options.caps)},
                        {"precision", options.output.writing.float32 ? "float32" : "float64"}}}}
      .dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

/// Notes the files that were read before.
void noteInputs(const MillFiles& files) {
  if (files.box.empty()) platform::noteInput(files.stock.path);
  platform::noteInput(files.path);
  for (const auto& [number, spec] : files.tools) {
    for (const std::string& file : spec.files()) platform::noteInput(file);
  }
}

mill::MillOptions optionsOfMilling(const MillInput& input, const MillOptions& options,
                                   const std::vector<double>& times) {
  mill::MillOptions how;
  how.voxelSize = options.voxelSize;
  how.times = times;
  how.tolerance = options.toleranceOr();
  how.travel = options.travel;
  how.memory = options.memory;
  for (const formats::Mounting& one : input.path.mountings) {
    how.mountings.push_back(mill::mountingOf(input.tools, one.time, one.tool));
  }
  how.rapids = input.path.rapids;
  how.caps = options.caps;
  return how;
}

}  // namespace

PathSummary summaryOf(const formats::ToolPath& path) {
  PathSummary summary;
  summary.dwell = path.dwell;
  int mounted = 0;
  for (const formats::Mounting& one : path.mountings) {
    const int tool = one.tool.value_or(mounted);
    summary.toolChanges += tool != mounted && mounted != 0 ? 1 : 0;
    mounted = tool;
  }
  std::size_t mounting = 0;
  std::size_t rapid = 0;
  for (const model::Segment& segment : path.motion.segments) {
    summary.extent.add(segment.start.translation);
    summary.extent.add(segment.end.translation);
    const double seconds = segment.timeEnd - segment.timeBegin;
    const double middle = 0.5 * (segment.timeBegin + segment.timeEnd);
    while (rapid < path.rapids.size() && path.rapids[rapid].end < middle) ++rapid;
    if (rapid < path.rapids.size() && path.rapids[rapid].begin < middle) {
      summary.rapid += seconds;
      continue;
    }
    while (mounting + 1 < path.mountings.size() && path.mountings[mounting + 1].time < middle) {
      ++mounting;
    }
    const bool holds = mounting < path.mountings.size() && path.mountings[mounting].time < middle;
    summary.cutting[holds ? path.mountings[mounting].tool.value_or(0) : 0] += seconds;
  }
  return summary;
}

Result<MillReport> mill(const MillInput& input, const MillOptions& options, Observer& observer) {
  const platform::Stopwatch stopwatch;
  const MillFiles& files = input.files;
  const model::Motion& motion = input.path.motion;
  const platform::KeptInputs kept;
  noteInputs(files);
  const auto times = voxel4d::frameTimes({motion.timeBegin(), motion.timeEnd()}, options.frames);
  if (!times) {
    Error error = times.error();
    error.where = files.path;
    return error;
  }
  auto file = T4dFile::create(options.output,
                              {"voxel4d", files.stock.path, motion.lengthUnit, motion.timeUnit,
                               millDetails(files, options, times->size())});
  if (!file) return file.error();
  auto milled = [&] {
    const auto stage = observer.stage("milling", times->size(), "frames");
    return mill::mill(input.stock, input.tools, motion, optionsOfMilling(input, options, *times),
                      *file, stage->callback());
  }();
  if (!milled) return atMillFile(milled.error(), files);
  const auto bytes = file->finish();
  if (!bytes) return bytes.error();
  MillReport report{.milled = std::move(*milled),
                    .path = summaryOf(input.path),
                    .motion = motion,
                    .mountings = input.path.mountings,
                    .bytes = *bytes};
  report.notices = report.milled.notices;
  if (!report.milled.firstCut) {
    report.notices.push_back(
        files.path +
        ": nothing is removed; the tool never meets the stock, or by less than the voxels show");
  }
  report.losses = input.losses;
  std::ranges::copy(file->losses(), std::back_inserter(report.losses));
  report.seconds = input.seconds + stopwatch.seconds();
  return report;
}

namespace {

void describePath(Members& members, const PathSummary& path) {
  members("min", path.extent.min, "Least coordinates of the tip, in the frame of the stock.");
  members("max", path.extent.max, "Largest coordinates of the tip.");
  members("cutting", std::vector(path.cutting.begin(), path.cutting.end()),
          "How long each tool moves by feed.", [](Members& own, const std::pair<int, double>& one) {
            own("tool", one.first, "Number of the tool; 0: one without a number.").atLeast(0);
            own("time", one.second, "In time units.").atLeast(0);
          });
  members("rapid_time", path.rapid, "How long rapid moves take.").atLeast(0);
  members("dwell_seconds", path.dwell,
          "How long the program dwells (G4), which the motion leaves out.")
      .atLeast(0);
  members("tool_changes", path.toolChanges, "Changes from one tool with a number to another.");
}

}  // namespace

void describe(Members& members, const MillReport& report) {
  const mill::MillReport& milled = report.milled;
  members("stock_volume", milled.stockVolume, "Volume of the first frame, the stock.").atLeast(0);
  members("removed_volume", milled.removedVolume, "Volume that was removed in all.").atLeast(0);
  members("remaining_volume", milled.remainingVolume, "Volume of the last frame.").atLeast(0);
  members("components", milled.components, "Parts that the workpiece consists of at the end.");
  members("frames", milled.progress.size(), "Frames that were woven.").atLeast(2);
  members("progress", milled.progress, "One for each frame.",
          [](Members& own, const mill::MillProgress& at) {
            own("time", at.time, "Time of the frame.");
            own("removed_volume", at.removedVolume, "Volume removed up to then.").atLeast(0);
            own("components", at.components, "Parts that the workpiece consists of then.");
          });
  members("separations", milled.separations, "When the workpiece falls apart.",
          [](Members& own, const mill::Separation& one) {
            own("begin", one.time.begin,
                "Time when the step of the tool that parts the voxels begins.");
            own("end", one.time.end,
                "Time when the tip has gone a voxel farther than in that step.");
            own("components", one.components, "Parts after it.").atLeast(2);
          });
  members("collisions", milled.collisions, "Contacts that must not be.",
          [](Members& own, const mill::Collision& one) {
            own("part", one.part, "What touches the stock; the tool, if a rapid move cuts.")
                .oneOf({"shank", "holder", "tool"});
            own("tool", one.tool,
                "Number of the tool that it is or belongs to; 0: tools have no numbers.")
                .atLeast(0);
            own("begin", one.time.begin,
                "Time when the first step of the tool with the contact begins.");
            own("end", one.time.end, "Time when the last one ends.");
            own("point", one.point,
                "A place of the contact in its first step, where it is deepest in the stock.");
          });
  const bool numbered = std::ranges::any_of(
      report.mountings, [](const auto& one) { return one.tool.value_or(0) > 0; });
  members("mountings", std::span(report.mountings).first(numbered ? report.mountings.size() : 0),
          "When tools are mounted; empty if they have no numbers.",
          [](Members& own, const formats::Mounting& one) {
            own("time", one.time, "From this time on.");
            own("tool", one.tool.value_or(0), "Number of the tool; 0: none.").atLeast(0);
          });
  members("path", report.path, "What the tool does.", describePath);
  members("returned_volume", milled.returnedVolume,
          "The most that comes back between frames and goes again, in cells that lean backward: 0, "
          "or a small part of what is removed.")
      .atLeast(0);
  members("steps", milled.steps, "Steps of the tool; the envelope of each was removed.").atLeast(1);
  members("vertices", milled.woven.vertices, "Vertices of the 4D mesh.");
  members("tetrahedra", milled.woven.tetrahedra, "Cells of the 4D mesh.");
  addCosts(members, report.seconds);
  members("bytes", report.bytes, "Size of the file, in bytes.");
}

}  // namespace t4d::verbs
