#include "tools/verbs/flipbook.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "formats/gltf/gltf_writer.h"
#include "formats/usd/usd_writer.h"
#include "model/units.h"
#include "t4d/convert.h"
#include "tools/verbs/members.h"
#include "tools/verbs/origin.h"
#include "tools/verbs/slice_writing.h"

namespace t4d::verbs {
namespace {

Result<void> checkFlipbookOptions(const FlipbookOptions& options) {
  const SliceWriteOptions& write = options.write;
  const bool byFrames = options.kind == FlipbookKind::Frames;
  const bool isUsd = formats::isUsd(options.output);
  const char* contradiction =
      !isUsd && !formats::isGltf(options.output) ? "a flipbook is a .glb, .gltf, .usda or .usdz"
      : !byFrames && (write.color == "time" || write.isColoredBySpeed() || write.isColoredByTrack())
          ? "a body that is moved or morphed has one colour"
      : !byFrames && (options.exact || write.velocity || options.visibility)
          ? "exact slices, velocities and visibilities are those of frames"
      : options.kind == FlipbookKind::Rigid && write.quantizeBits
          ? "bodies that are moved by poses have float32 coordinates"
      : options.kind == FlipbookKind::Morph && write.quantizeBits > 15
          ? "shapes of morphed bodies have at most 15 bits"
      : options.framesPerSecond && options.seconds
          ? "frames per second and seconds of playback are given both"
      : options.visibility && isUsd ? "USD shows and hides bodies by their visibility in any case"
                                    : nullptr;
  if (contradiction != nullptr) return fail(ErrorCode::Options, contradiction);
  return checkSliceWriteOptions(write, options.output);
}

/// Whether the times between frames differ by less than anybody sees.
bool areEven(std::span<const double> times) {
  constexpr double kUnseen = 0.01;  // of the time between two frames
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double even = times.front() + static_cast<double>(i) * step;
    if (std::abs(times[i] - even) > kUnseen * std::abs(step)) return false;
  }
  return true;
}

/// The frames per second at which each is shown at its own time; nothing if its unit is another
/// than the second, and for frames that are not evenly spaced.
std::optional<double> realRate(std::span<const double> times, const std::string& timeUnit) {
  const auto seconds = model::timeConversion(timeUnit, "s");
  if (!seconds || !seconds->isIdentity()) return std::nullopt;
  if (times.front() == times.back() || !areEven(times)) return std::nullopt;
  return static_cast<double>(times.size() - 1) / std::abs(times.back() - times.front());
}

double rateOf(const FlipbookOptions& options, std::size_t frames, std::optional<double> realRate) {
  constexpr double kUsual = 24;
  if (options.framesPerSecond) return *options.framesPerSecond;
  if (options.seconds) return static_cast<double>(frames) / *options.seconds;
  return realRate.value_or(kUsual);
}

Result<convert::FrameSlicesReport> writeFrames(const Input& input, const FlipbookOptions& options,
                                               std::span<const double> times,
                                               const convert::FlipbookOptions& how,
                                               Observer& observer) {
  // The other two kinds read slabs once for all frames.
  const bool byFrames = options.kind == FlipbookKind::Frames;
  const auto stage = observer.stage("slicing", byFrames ? times.size() : 0, "frames");
  const auto write = options.kind == FlipbookKind::Rigid   ? convert::writeRigidFlipbook
                     : options.kind == FlipbookKind::Morph ? convert::writeMorphFlipbook
                                                           : convert::writeFlipbook;
  auto written = write(input.bodies, times, options.output, how, stage->callback());
  if (!written) return inInput(written.error(), input);
  return written;
}

std::uint64_t sizeOfFiles(const std::vector<std::filesystem::path>& files) {
  std::uint64_t bytes = 0;
  for (const std::filesystem::path& file : files) {
    std::error_code unknown;
    const std::uintmax_t size = std::filesystem::file_size(file, unknown);
    if (!unknown) bytes += size;
  }
  return bytes;
}

}  // namespace

Result<FlipbookReport> flipbook(const Input& input, const FlipbookOptions& options,
                                Observer& observer) {
  if (auto good = checkFlipbookOptions(options); !good) return good.error();
  const std::vector<double> times = timesOfFrames(options.times, input);
  std::vector<std::string> notices;
  const formats::GltfPlacement placement = placementOf(input.metadata, notices);
  observer.noteEach(notices);
  convert::FlipbookOptions how;
  const std::optional<double> real = realRate(times, input.metadata.timeUnit);
  how.framesPerSecond = rateOf(options, times.size(), real);
  const bool exact = options.exact || options.write.isColoredByTrack();
  how.detail = exact ? slice::SliceDetail::Exact : slice::SliceDetail::Light;
  std::vector<double> rates;
  if (options.write.needsVelocity()) {
    if (times.size() == 1) return oneFrameHasNoSpeed();
    rates = convert::playbackRates(times, how.framesPerSecond);
  }
  auto looks = frameLooksOf(options.write, input, times, how.detail, std::move(rates), observer);
  if (!looks) return looks.error();
  how.write = looks->write;
  how.write.placement = placement;
  how.write.gltf.visibility = options.visibility;
  how.velocity = looks->velocity;
  how.paint = looks->painting.paint;
  how.meanings = input.metadata.attributes;
  auto written = writeFrames(input, options, times, how, observer);
  if (!written) return written.error();
  const std::vector<std::filesystem::path>& files = written->files;
  if (files.size() > 1) {
    written->notices.push_back(fmt::format(
        "a glTF file cannot hold all frames: they are in {} files, {} to {}, one after the other",
        files.size(), files.front().string(), files.back().string()));
  }
  observer.noteEach(written->notices);
  FlipbookReport report;
  report.kind = options.kind;
  report.bytes = sizeOfFiles(files);
  report.written = std::move(*written);
  report.firstTime = times.front();
  report.lastTime = times.back();
  report.seconds = static_cast<double>(times.size()) / how.framesPerSecond;
  report.inRealTime = real == how.framesPerSecond;
  report.hasVelocity = how.velocity.has_value();
  report.colorRange = looks->painting.range;
  report.quantizationError = quantizationErrorOf(how.write.gltf);
  return report;
}

void describe(Members& members, const FlipbookReport& report) {
  const convert::FrameSlicesReport& written = report.written;
  members("frames", written.frames, "Number of frames.").atLeast(1).atMost(100'000);
  members("triangles", written.triangles,
          "Triangles of all frames together; of all bodies, if rigid or morph.");
  members("time_begin", report.firstTime, "The mesh's time at the first frame, in its time units.");
  members("time_end", report.lastTime, "The mesh's time at the last frame, in its time units.");
  members("seconds", report.seconds,
          "Duration of the animation, in seconds: frames divided by --fps.")
      .above(0);
  members("bytes", report.bytes, "Size of all files together, in bytes.");
  members("files", written.files,
          "Paths of the files. If one file would be too large for its format, there are several, "
          "each with the frames after those of the previous file.")
      .itemsFrom(1);
  members("rigid", report.kind == FlipbookKind::Rigid,
          "Whether there is one mesh for each body, moved by its poses, instead of frames.");
  members("morph", report.kind == FlipbookKind::Morph,
          "Whether there is one mesh for each body, with a morph target for each layer, instead of "
          "frames.");
  addFrameMembers(members, written, report.hasVelocity, report.colorRange,
                  report.quantizationError);
}

}  // namespace t4d::verbs
