#include "tools/t4d/weave_input.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/file_extension.h"
#include "formats/t4d/url.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/amount_text.h"
#include "platform/stopwatch.h"
#include "t4d/frames.h"
#include "voxel4d/advected_frames.h"
#include "voxel4d/frame_formats.h"
#include "voxel4d/volumes/frame_stream.h"
#include "voxel4d/volumes/volume_labels.h"
#include "voxel4d/volumes/volume_velocity.h"

namespace t4d::tools {
namespace {

std::vector<std::filesystem::path> pathsOf(const std::vector<std::string>& files) {
  return {files.begin(), files.end()};
}

/// Fails if a folder holds volumes, but no .vdb files: only the latter are taken by the folder.
Result<void> checkFrameFolder(const std::string& folder) {
  std::error_code ignored;
  std::set<std::string> volumes;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".vdb") return {};
    if (voxel4d::isVolumeFile(entry.path())) volumes.insert(entry.path().filename().string());
  }
  if (volumes.empty()) return {};
  return invalid(fmt::format("is a folder of {}, and none is a .vdb file; name the volumes, as {}",
                             model::counted(volumes.size(), "volume"),
                             (std::filesystem::path(folder) /
                              ("*" + std::filesystem::path(*volumes.begin()).extension().string()))
                                 .string()),
                 folder);
}

/// Frames that another program writes to standard input.
constexpr std::string_view kStream = "-";

FrameKind kindOfFrame(const std::string& file) {
  if (file == kStream) return FrameKind::Volumes;
  if (isMeshFrame(file)) return FrameKind::Meshes;
  return voxel4d::isVolumeFile(file) ? FrameKind::Volumes : FrameKind::Vdb;
}

/// For a file that is neither a volume by its extension nor a VDB file, both are said.
Error unreadableFrame(Error error) {
  const std::string extension = formats::lowerCaseExtension(error.where.file);
  if (error.remedy == Remedy::FrameFormat && extension != ".vdb") {
    error.message +=
        fmt::format(", and not a volume by its extension; expected .vdb, {}, or triangle meshes",
                    volumeExtensions());
  }
  return error;
}

/// Adds frames that velocities carry to volumes.
Result<void> addFramesInBetween(const WeaveInput& input, const voxel4d::VolumeOptions& options,
                                voxel4d::VolumeFrames& opened) {
  if (opened.frames->isOneApart()) {
    return invalid("velocities need the time from frame to frame, which the file does not say",
                   opened.name.empty() ? input.files.front() : opened.name, Remedy::FrameTime);
  }
  auto velocities =
      voxel4d::openVolumeVelocity(pathsOf(input.reading.velocityFiles), options, opened);
  if (!velocities) return velocities.error();
  opened.frames = voxel4d::advectedFrames(std::move(opened.frames), std::move(*velocities),
                                          input.reading.steps());
  return {};
}

/// The region, which openFrames has checked.
std::optional<voxel4d::Region> regionOf(const FrameReading& reading) {
  if (reading.region.empty()) return std::nullopt;
  return *voxel4d::parseRegion(reading.region);
}

voxel4d::VolumeOptions volumeOptionsOf(const WeaveInput& input) {
  voxel4d::VolumeOptions options = input.reading.volumes;
  options.region = regionOf(input.reading);
  return options;
}

/// Opens the samples that have the label, or are inside without one.
Result<voxel4d::VolumeFrames> openVolumes(const WeaveInput& input,
                                          const std::optional<std::int64_t>& label) {
  voxel4d::VolumeOptions options = volumeOptionsOf(input);
  options.label = label;
  auto opened = voxel4d::openVolumeFrames(pathsOf(input.files), options);
  if (opened && !input.reading.velocityFiles.empty()) {
    if (auto done = addFramesInBetween(input, options, *opened); !done) return done.error();
  }
  return opened;
}

/// Says in which order the grids of .vdb files are whose names alone say it.
void noticeOrderOfNames(WeaveInput& input) {
  const voxel4d::VolumeOptions& how = input.reading.volumes;
  const voxel4d::FrameSource& frames = *input.frames.frames;
  std::error_code ignored;
  const bool isByName =
      input.files.size() == 1 || std::ranges::any_of(input.files, [&](const std::string& file) {
        return std::filesystem::is_directory(file, ignored);
      });
  const bool hasOwnTimes = !frames.isOneApart() && !how.frameTime && how.times.empty();
  if (!isByName || hasOwnTimes) return;
  const Place first = frames.placeOf(0);
  const Place last = frames.placeOf(frames.frameCount() - 1);
  input.notices.push_back(first.file == last.file ? orderNotice(first.text(), last.text())
                                                  : orderNotice(first.file, last.file));
}

Result<void> openVdb(WeaveInput& input) {
  const FrameReading& reading = input.reading;
  voxel4d::VdbFramesOptions options;
  options.iso = reading.volumes.iso;
  options.below = reading.volumes.below;
  options.frameTime = reading.volumes.frameTime;
  options.startTime = reading.volumes.startTime.value_or(0);
  options.times = reading.volumes.times;
  options.region = regionOf(reading);
  options.grid = reading.grid;
  options.velocity = reading.velocity;
  options.substeps = reading.steps();
  auto frames = voxel4d::openVdbFrames(pathsOf(input.files), options);
  if (!frames) return unreadableFrame(frames.error());
  input.frames.frames = std::move(*frames);
  noticeOrderOfNames(input);
  return {};
}

Result<void> openMeshes(WeaveInput& input) {
  const FrameReading& reading = input.reading;
  if (!reading.voxelSize) {
    return fail(ErrorCode::Options, "triangle meshes need the edge length of a voxel");
  }
  auto opened =
      openMeshFrames(input.files, {*reading.voxelSize, reading.volumes.frameTime,
                                   reading.volumes.startTime.value_or(0), reading.volumes.times});
  if (!opened) return opened.error();
  input.meshes = std::move(opened->log);
  input.frames.frames = std::move(opened->frames);
  return {};
}

std::string noticeOfLabels(const std::vector<std::int64_t>& labels) {
  constexpr std::size_t kMostNamed = 20;
  const std::span named = std::span(labels).first(std::min(labels.size(), kMostNamed));
  return fmt::format("found {}, each a body: {}{}; 0 is the background",
                     model::counted(labels.size(), "label"), fmt::join(named, ", "),
                     labels.size() > kMostNamed ? ", ..." : "");
}

Result<void> openKind(FrameKind kind, WeaveInput& input) {
  if (kind != FrameKind::Volumes) input.reading.labels.clear();
  if (kind == FrameKind::Meshes) return openMeshes(input);
  if (kind == FrameKind::Vdb) return openVdb(input);
  if (input.files.front() == kStream) {
    const bool again = input.reading.allLabels || input.reading.labels.size() > 1;
    input.reading.volumes.input = std::make_shared<voxel4d::InputBytes>(again);
  }
  if (input.reading.allLabels) {
    auto found = voxel4d::labelsOf(pathsOf(input.files), volumeOptionsOf(input));
    if (!found) return found.error();
    input.reading.labels = std::move(*found);
    input.notices.push_back(noticeOfLabels(input.reading.labels));
  }
  const auto& labels = input.reading.labels;
  auto opened = openVolumes(
      input, labels.empty() ? std::nullopt : std::optional<std::int64_t>(labels.front()));
  if (!opened) return opened.error();
  input.frames = std::move(*opened);
  if (!input.frames.name.empty()) input.name = input.frames.name;
  return {};
}

}  // namespace

std::string orderNotice(const std::string& first, const std::string& last) {
  return fmt::format("frames are in the order of the numbers in their names, from {} to {}", first,
                     last);
}

std::string volumeExtensions() {
  return fmt::format("{}", fmt::join(voxel4d::volumeExtensions(), ", "));
}

Result<FrameKind> frameKindOf(std::span<const std::string> files) {
  if (files.empty()) return fail(ErrorCode::Options, "no frames are given");
  if (files.size() > 1 && std::ranges::find(files, kStream) != files.end()) {
    return fail(ErrorCode::Options,
                "standard input (-) has all frames; no file is given beside it");
  }
  for (const std::string& file : files) {
    if (auto good = checkFrameFolder(file); !good) return good.error();
    // A mesh of a format that is only written is none of what can be woven.
    if (formats::triangleMeshFormat(file) == nullptr) continue;
    if (auto good = formats::checkMeshExtension(file); !good) return good.error();
  }
  const FrameKind kind = kindOfFrame(files.front());
  for (const std::string& file : files) {
    if (kindOfFrame(file) == kind) continue;
    return fail(
        ErrorCode::Options,
        fmt::format("{} and {} are not of one kind; give .vdb files, volumes, or triangle meshes",
                    files.front(), file));
  }
  return kind;
}

Result<WeaveInput> openFrames(std::vector<std::string> files, FrameReading reading) {
  const platform::Stopwatch stopwatch;
  const auto kind = frameKindOf(files);
  if (!kind) return kind.error();
  WeaveInput input{
      .name = formats::shownName(files.front()), .frames = {}, .files = std::move(files)};
  input.reading = std::move(reading);
  if (auto opened = openKind(*kind, input); !opened) return opened.error();
  input.seconds = stopwatch.seconds();
  return input;
}

Result<voxel4d::VolumeFrames> framesOfLabel(const WeaveInput& input, std::int64_t label) {
  return openVolumes(input, label);
}

}  // namespace t4d::tools
