#include "t4d/convert/flipbook.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/convert/slice.h"

namespace t4d::convert {

std::vector<double> evenTimes(double begin, double end, std::size_t count) {
  std::vector<double> times;
  times.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const bool last = i > 0 && i + 1 == count;
    times.push_back(last ? end
                         : begin + (end - begin) *
                                       (static_cast<double>(i) /
                                        static_cast<double>(std::max<std::size_t>(1, count - 1))));
  }
  return times;
}

Result<FlipbookReport> writeFlipbook(std::span<const model::Body> bodies,
                                     std::span<const double> times,
                                     const std::filesystem::path& path,
                                     const formats::GltfPlacement& placement,
                                     double framesPerSecond,
                                     const formats::MeshWriteOptions& options,
                                     const model::Progress& progress) {
  const model::TimeSpan span = model::timeSpanOf(bodies);
  for (const double time : times) {
    if (!(time >= span.begin && time <= span.end)) {
      return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", time,
                                 span.begin, span.end));
    }
  }
  auto writer = formats::FlipbookWriter::create(path, placement, framesPerSecond, options);
  if (!writer) return pass(writer.error());
  FlipbookReport report;
  for (const double time : times) {
    std::vector<formats::NamedMesh> meshes;
    for (const model::Body& body : bodies) {
      const model::TimeSpan own = model::timeSpanOf(*body.source);
      if (time < own.begin || time > own.end) continue;
      auto slice = sliceAtTime(*body.source, time);
      if (!slice) return pass(slice.error());
      report.triangles += slice->mesh.triangles.size();
      meshes.push_back({body.name, std::move(slice->mesh)});
    }
    if (auto added = writer->add(time, meshes); !added) return pass(added.error());
    ++report.frames;
    if (progress) progress(static_cast<double>(report.frames) / static_cast<double>(times.size()));
  }
  auto losses = writer->finish();
  if (!losses) return pass(losses.error());
  report.losses = std::move(*losses);
  return report;
}

}  // namespace t4d::convert
