#include "t4d/convert/flipbook.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/convert/slice.h"

namespace t4d::convert {

Result<FlipbookReport> writeFlipbook(std::span<const model::Body> bodies,
                                     std::span<const double> times,
                                     const std::filesystem::path& path, double framesPerSecond,
                                     const formats::MeshWriteOptions& options,
                                     const model::Progress& progress) {
  if (std::all_of(bodies.begin(), bodies.end(),
                  [](const model::Body& body) { return body.source->slabCount() == 0; })) {
    return invalid("there is nothing to show: no body has a slab");
  }
  if (times.empty()) return invalid("there are no times to show the mesh at");
  const model::TimeSpan span = model::timeSpanOf(bodies);
  for (const double time : times) {
    if (!model::timeWithin(span, time)) {
      return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", time,
                                 span.begin, span.end));
    }
  }
  auto writer = formats::FlipbookWriter::create(path, framesPerSecond, options);
  if (!writer) return pass(writer.error());
  FlipbookReport report;
  for (const double time : times) {
    std::vector<formats::NamedMesh> meshes;
    for (const model::Body& body : bodies) {
      if (!model::timeWithin(*body.source, time)) continue;
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
