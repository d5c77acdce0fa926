#include "tools/verbs/weave.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/url.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "tools/verbs/lost_parts.h"
#include "tools/verbs/members.h"
#include "tools/verbs/weave_names.h"

namespace t4d::verbs {
namespace {

using nlohmann::ordered_json;

/// The data on how the file was made, for its metadata.
std::string weaveDetails(const WeaveInput& input, const WeaveOptions& options) {
  const FrameReading& reading = input.reading;
  ordered_json parameters;
  if (reading.voxelSize) parameters["voxel_size"] = *reading.voxelSize;
  if (reading.volumes.iso) {
    parameters[reading.volumes.below ? "below" : "iso"] = *reading.volumes.iso;
  }
  if (const auto& outside = reading.volumes.outside) {
    parameters["outside_value"] =
        std::isnan(*outside) ? ordered_json("nan") : ordered_json(*outside);
  }
  if (!reading.labels.empty()) parameters["labels"] = reading.labels;
  if (!reading.region.empty()) parameters["region"] = reading.region;
  if (reading.hasVelocity()) {
    std::vector<std::string> names;
    for (const std::string& file : reading.velocityFiles) {
      names.push_back(nameIn(formats::shownName(file)).string());
    }
    parameters["velocity"] =
        names.empty() ? reading.velocity : fmt::format("{}", fmt::join(names, ", "));
    parameters["substeps"] = reading.steps();
  }
  parameters["caps"] = nameOfCaps(options.caps);
  parameters["between"] = nameOfBetween(options.between);
  parameters["precision"] = options.output.writing.float32 ? "float32" : "float64";
  if (options.output.writing.step) parameters["grid"] = *options.output.writing.step;
  ordered_json source{{"frames", nameIn(input.name).string()}};
  if (reading.voxelSize && input.files.size() > 1) source["meshes"] = input.files.size();
  return ordered_json{{"source", source}, {"parameters", parameters}}.dump(
      -1, ' ', false, ordered_json::error_handler_t::replace);
}

T4dFile::About aboutWeaving(const WeaveInput& input, const WeaveOptions& options) {
  const auto unit = [](const std::string& given, const std::string& ofFile) {
    return given.empty() ? ofFile : given;
  };
  T4dFile::About about = {"voxel4d", input.name, unit(options.lengthUnit, input.frames.lengthUnit),
                          unit(options.timeUnit, input.frames.timeUnit),
                          weaveDetails(input, options)};
  about.space = input.frames.space;
  const auto& labels = input.reading.labels;
  for (std::size_t i = 0; labels.size() > 1 && i < labels.size(); ++i) {
    const std::string& name = options.output.body;
    about.bodies.push_back({fmt::format("{} {}", name.empty() ? "label" : name, labels[i])});
  }
  return about;
}

/// Frames of velocities in between, of those that a part counts.
std::uint64_t framesInBetween(const model::Part& part, std::uint64_t frames, std::uint64_t steps) {
  const model::PartRange own = part.of(frames - 1);
  const auto ofFiles = [&](std::uint64_t end) { return end / steps + 1; };  // among 0 .. end
  const std::uint64_t before = part.isFirst() ? 0 : ofFiles(own.begin);
  const std::uint64_t counted = own.size() + (part.isFirst() ? 1 : 0);
  return counted - (ofFiles(own.end) - before);
}

/// Weaves the frames of one body and adds it to the report.
Result<void> weaveBody(const WeaveInput& input, const WeaveOptions& options, T4dFile& file,
                       WeaveReport& report, Observer& observer) {
  const auto stage = observer.stage("weaving", input.frames.frames->frameCount(), "frames");
  const auto body = voxel4d::weave(*input.frames.frames,
                                   {.caps = options.caps,
                                    .between = options.between,
                                    .toSpace = input.frames.toSpace,
                                    .part = options.part},
                                   file, stage->callback());
  if (!body) return body.error();
  voxel4d::WeaveReport& all = report.woven;
  all.vertices += body->vertices;
  all.tetrahedra += body->tetrahedra;
  // The first frame of a part is counted by the part before.
  all.frames = body->frames - (options.part.isFirst() ? 0 : 1);
  all.masks += body->masks;
  for (int end = 0; end < 2; ++end) all.capTetrahedra[end] += body->capTetrahedra[end];
  all.partsLost.add(body->partsLost);
  return {};
}

Result<void> weaveBodies(WeaveInput& input, const WeaveOptions& options, T4dFile& file,
                         WeaveReport& report, Observer& observer) {
  const auto& labels = input.reading.labels;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, labels.size()); ++i) {
    if (i > 0) {
      auto frames = framesOfLabel(input, labels[i]);
      if (!frames) return frames.error();
      input.frames = std::move(*frames);
    }
    file.setBody(i);
    if (auto woven = weaveBody(input, options, file, report, observer); !woven) {
      Error error = woven.error();
      if (input.meshes) {
        observer.noteEach(input.meshes->notices);
        if (error.where.empty()) error.where = input.files.front();
      }
      return error;
    }
    if (const std::string notice = input.frames.frames->notice(); !notice.empty()) {
      report.notices.push_back(labels.size() > 1 ? fmt::format("label {}: {}", labels[i], notice)
                                                 : notice);
    }
  }
  return {};
}

/// Notes the files that were opened before.
void noteInputs(const WeaveInput& input) {
  for (const std::string& file : input.files) platform::noteInput(file);
  for (const std::string& file : input.reading.velocityFiles) platform::noteInput(file);
}

}  // namespace

Result<WeaveReport> weave(WeaveInput input, const WeaveOptions& options, Observer& observer) {
  const platform::Stopwatch stopwatch;
  const platform::KeptInputs kept;
  noteInputs(input);
  if (options.output.center && options.part.count > 1) {
    return fail(ErrorCode::Options, "a part cannot be centred: the parts would not meet");
  }
  const std::uint64_t frameCount = input.frames.frames->frameCount();
  auto file = T4dFile::create(options.output, aboutWeaving(input, options));
  if (!file) return file.error();
  WeaveReport report;
  report.notices = input.notices;
  if (!input.frames.notice.empty()) {
    report.notices.push_back(fmt::format("{}: {}", input.name, input.frames.notice));
  }
  std::ranges::copy(input.frames.notes, std::back_inserter(report.notices));
  if (auto woven = weaveBodies(input, options, *file, report, observer); !woven) {
    return woven.error();
  }
  const auto bytes = file->finish();
  if (!bytes) return bytes.error();
  report.framesInBetween = framesInBetween(options.part, frameCount, input.reading.steps());
  report.bytes = *bytes;
  report.space = input.frames.space;
  report.unsized = input.frames.unsized;
  report.assumedAxes = input.frames.assumedAxes;
  report.lengthUnit = options.lengthUnit.empty() ? input.frames.lengthUnit : options.lengthUnit;
  report.timeUnit = options.timeUnit.empty() ? input.frames.timeUnit : options.timeUnit;
  report.oneApart = input.frames.frames->isOneApart();
  report.takenAsDistances = input.frames.takenAsDistances;
  if (input.meshes) {
    std::ranges::copy(input.meshes->notices, std::back_inserter(report.notices));
    report.losses = input.meshes->losses;
  }
  std::ranges::copy(input.frames.losses, std::back_inserter(report.losses));
  std::ranges::copy(file->losses(), std::back_inserter(report.losses));
  report.seconds = input.seconds + stopwatch.seconds();
  return report;
}

void describe(Members& members, const WeaveReport& report) {
  const voxel4d::WeaveReport& woven = report.woven;
  members("vertices", woven.vertices, "Vertices of the 4D mesh, each once.")
      .atLeast(5)
      .joined(Joined::Added);
  members("tetrahedra", woven.tetrahedra, "Cells of the 4D mesh, caps included.")
      .atLeast(5)
      .joined(Joined::Added);
  members("frames", woven.frames,
          "Frames that were woven: grids or meshes that were read, and those in between.")
      .atLeast(2)
      .joined(Joined::Added);
  members("frames_in_between", report.framesInBetween,
          "Of these, the frames that --velocity made between those that were read.")
      .joined(Joined::Added);
  addCosts(members, report.seconds);
  members("cap_tetrahedra", woven.capTetrahedra,
          "Cells that close the mesh at its first and at its last time.")
      .joined(Joined::Added);
  members(
      "space", report.space.empty() ? std::nullopt : std::optional(report.space),
      "What positions are relative to a patient: RAS is x to the right, y anterior, z superior; "
      "LPS is x to the left, y posterior, z superior. null where the files do not say.")
      .oneOf({"RAS", "LPS"})
      .joined(Joined::First);
  members("bytes", report.bytes, "Size of the file, in bytes.").joined(Joined::Unknown);
  addLostParts(members, woven.partsLost);
}

}  // namespace t4d::verbs
