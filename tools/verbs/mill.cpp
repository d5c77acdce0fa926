#include "tools/verbs/mill.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "tools/verbs/json_text.h"
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

std::string jsonOf(const MillReport& report, std::uint64_t peakBytes) {
  const mill::MillReport& milled = report.milled;
  ordered_json value{
      {"stock_volume", milled.stockVolume},         {"removed_volume", milled.removedVolume},
      {"remaining_volume", milled.remainingVolume}, {"components", milled.components},
      {"frames", milled.progress.size()},           {"progress", ordered_json::array()},
      {"separations", ordered_json::array()},       {"collisions", ordered_json::array()}};
  for (const mill::MillProgress& at : milled.progress) {
    value["progress"].push_back(
        {{"time", at.time}, {"removed_volume", at.removedVolume}, {"components", at.components}});
  }
  for (const mill::Separation& one : milled.separations) {
    value["separations"].push_back(
        {{"begin", one.time.begin}, {"end", one.time.end}, {"components", one.components}});
  }
  for (const mill::Collision& one : milled.collisions) {
    value["collisions"].push_back({{"part", one.part},
                                   {"tool", one.tool},
                                   {"begin", one.time.begin},
                                   {"end", one.time.end},
                                   {"point", {one.point.x(), one.point.y(), one.point.z()}}});
  }
  value["mountings"] = ordered_json::array();
  const bool numbered = std::ranges::any_of(
      report.mountings, [](const auto& one) { return one.tool.value_or(0) > 0; });
  for (const formats::Mounting& one : report.mountings) {
    if (!numbered) break;
    value["mountings"].push_back({{"time", one.time}, {"tool", one.tool.value_or(0)}});
  }
  const auto xyz = [](const model::Point3& point) {
    return ordered_json::array({point.x(), point.y(), point.z()});
  };
  ordered_json path{
      {"min", xyz(report.path.extent.min)}, {"max", xyz(report.path.extent.max)},
      {"cutting", ordered_json::array()},   {"rapid_time", report.path.rapid},
      {"dwell_seconds", report.path.dwell}, {"tool_changes", report.path.toolChanges}};
  for (const auto& [tool, time] : report.path.cutting) {
    path["cutting"].push_back({{"tool", tool}, {"time", time}});
  }
  value["path"] = path;
  value["returned_volume"] = milled.returnedVolume;
  value["steps"] = milled.steps;
  value["vertices"] = milled.woven.vertices;
  value["tetrahedra"] = milled.woven.tetrahedra;
  value["seconds"] = report.seconds;
  value["peak_bytes"] = peakBytes;
  value["bytes"] = report.bytes;
  return jsonText(value);
}

}  // namespace t4d::verbs
