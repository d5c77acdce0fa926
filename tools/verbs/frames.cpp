#include "tools/verbs/frames.h"

#include <fmt/format.h>

#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/usd/usd_writer.h"
#include "tools/verbs/members.h"
#include "tools/verbs/origin.h"
#include "tools/verbs/slice_writing.h"

namespace t4d::verbs {
namespace {

/// A name with the extension of the frames.
std::string anyFrame(const FramesOptions& options) { return "a" + options.names.extension; }

Result<void> checkFramesOptions(const FramesOptions& options, std::size_t frames) {
  if (options.part.count > frames) {
    return fail(ErrorCode::Options, fmt::format("there are {} frames, too few for {} parts", frames,
                                                options.part.count));
  }
  if (options.part.count > 1 && formats::isUsd(anyFrame(options))) {
    return fail(ErrorCode::Options, "USD frames come with a file of all, for which each is needed");
  }
  if (options.light && options.write.isColoredByTrack()) {
    return fail(ErrorCode::Options, "colours by track are those of exact slices");
  }
  return checkSliceWriteOptions(options.write, anyFrame(options));
}

}  // namespace

Result<FramesReport> frames(const Input& input, const FramesOptions& options, Observer& observer) {
  const std::vector<double> times = timesOfFrames(options.times, input);
  if (auto good = checkFramesOptions(options, times.size()); !good) return good.error();
  const formats::Metadata& metadata = input.metadata;
  const bool inPlayback = options.inPlayback || formats::isUsd(anyFrame(options));
  if (inPlayback && options.write.velocity && times.size() == 1) return oneFrameHasNoSpeed();
  convert::FrameFilesOptions how;
  how.part = options.part;
  how.detail = options.light ? slice::SliceDetail::Light : slice::SliceDetail::Exact;
  how.space = {metadata.lengthUnit, metadata.timeUnit, metadata.up};
  how.framesPerSecond = options.framesPerSecond;
  auto looks = frameLooksOf(
      options.write, input, times, how.detail,
      inPlayback ? convert::playbackRates(times, options.framesPerSecond) : std::vector<double>(),
      observer);
  if (!looks) return looks.error();
  how.write = looks->write;
  how.velocity = looks->velocity;
  how.paint = looks->painting.paint;
  const auto* format = formats::triangleMeshFormat(anyFrame(options));
  if (format != nullptr && format->placed) {
    std::vector<std::string> notices;
    how.write.placement = placementOf(metadata, notices);
    observer.noteEach(notices);
  }
  const model::PartRange own = options.part.of(times.size());
  auto written = [&] {
    const auto stage = observer.stage("slicing", own.size(), "frames");
    return convert::writeFrameFiles(input.bodies, times, options.names, how, stage->callback());
  }();
  if (!written) return inInput(written.error(), input);
  observer.noteEach(written->notices);
  FramesReport report;
  report.written = std::move(*written);
  report.manifest =
      options.names.folder / (options.part.count > 1
                                  ? convert::manifestOfPart(options.names.manifest, options.part)
                                  : options.names.manifest);
  report.firstTime = times[own.begin];
  report.lastTime = times[own.end - 1];
  report.hasVelocity = how.velocity.has_value();
  report.colorRange = looks->painting.range;
  report.quantizationError = quantizationErrorOf(how.write.gltf);
  return report;
}

void describe(Members& members, const FramesReport& report) {
  const convert::FrameFilesReport& written = report.written;
  members("frames", written.frames, "Number of frames, each a file.")
      .atLeast(1)
      .atMost(1'000'000)
      .joined(Joined::Added);
  members("triangles", report.ofGrids ? std::nullopt : std::optional(written.triangles),
          "Triangles of all frames together; null for OpenVDB grids.")
      .joined(Joined::Added);
  members("time_begin", report.firstTime, "The mesh's time at the first frame, in its time units.")
      .joined(Joined::First);
  members("time_end", report.lastTime, "The mesh's time at the last frame, in its time units.")
      .joined(Joined::Last);
  members("bytes", written.bytes, "Size of all frames together, in bytes.").joined(Joined::Added);
  members("manifest", report.manifest, "Path of the manifest, which lists the files.")
      .joined(Joined::First);
  addFrameMembers(members, written, report.hasVelocity, report.colorRange,
                  report.quantizationError);
}

}  // namespace t4d::verbs
