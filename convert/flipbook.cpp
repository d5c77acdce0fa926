#include "convert/flipbook.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "convert/frame_slices.h"
#include "formats/gltf/gltf_writer.h"
#include "formats/usd/usd_writer.h"
#include "t4d/convert.h"

namespace t4d::convert {
namespace {

template <class Writer>
Result<FrameSlicesReport> writeFrames(std::span<const model::Body> bodies,
                                      std::span<const double> times, Result<Writer> writer,
                                      const FlipbookOptions& options,
                                      const model::Progress& progress) {
  if (!writer) return writer.error();
  auto report = forEachFrame(
      bodies, times, {options.detail, options.velocity, options.paint, options.write.attributes},
      [&](std::size_t frame, std::span<const formats::NamedMesh> meshes) {
        return writer->add(times[frame], meshes);
      },
      progress);
  if (!report) return report;
  if (!options.write.attributes) report->losses.clear();
  auto losses = writer->finish();
  if (!losses) return losses.error();
  for (std::string& loss : *losses) report->losses.push_back(std::move(loss));
  report->files = writer->files();
  return report;
}

}  // namespace

Result<void> checkFlipbook(std::span<const model::Body> bodies, std::span<const double> times,
                           const FlipbookOptions& options) {
  if (!(options.framesPerSecond > 0) || !std::isfinite(options.framesPerSecond)) {
    return invalid(
        fmt::format("{} frames a second, expected more than 0", options.framesPerSecond));
  }
  return checkFrameTimes(bodies, times);
}

Result<FrameSlicesReport> writeFlipbook(std::span<const model::Body> bodies,
                                        std::span<const double> times,
                                        const std::filesystem::path& path,
                                        const FlipbookOptions& options,
                                        const model::Progress& progress) {
  formats::MeshWriteOptions write = options.write;
  write.attributes = write.attributes || options.velocity;
  const double perSecond = options.framesPerSecond;
  if (formats::isUsd(path)) {
    return writeFrames(bodies, times,
                       formats::UsdWriter::create(path, perSecond, times.size(), write), options,
                       progress);
  }
  return writeFrames(bodies, times, formats::FlipbookWriter::create(path, perSecond, write),
                     options, progress);
}

}  // namespace t4d::convert
