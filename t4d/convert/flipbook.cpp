#include "t4d/convert/flipbook.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/convert/in_order.h"
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
  std::vector<std::unique_ptr<TimeSlicer>> slicers;
  for (const model::Body& body : bodies) {
    slicers.push_back(std::make_unique<TimeSlicer>(*body.source));
  }
  using Meshes = std::vector<formats::NamedMesh>;
  const auto meshesAt = [&](std::size_t frame) -> std::shared_ptr<Result<Meshes>> {
    Meshes meshes;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (!model::timeWithin(*bodies[i].source, times[frame])) continue;
      auto slice = slicers[i]->at(times[frame]);
      if (!slice) return std::make_shared<Result<Meshes>>(pass(slice.error()));
      meshes.push_back({bodies[i].name, std::move(slice->mesh)});
    }
    return std::make_shared<Result<Meshes>>(std::move(meshes));
  };
  FlipbookReport report;
  Result<void> done;
  inOrder<std::shared_ptr<Result<Meshes>>>(times.size(), meshesAt, [&](const auto& meshes) {
    if (!*meshes) {
      done = pass(meshes->error());
      return false;
    }
    for (const formats::NamedMesh& mesh : **meshes) report.triangles += mesh.mesh.triangles.size();
    done = writer->add(times[report.frames], **meshes);
    if (!done) return false;
    ++report.frames;
    if (progress) progress(static_cast<double>(report.frames) / static_cast<double>(times.size()));
    return true;
  });
  if (!done) return pass(done.error());
  auto losses = writer->finish();
  if (!losses) return pass(losses.error());
  report.losses = std::move(*losses);
  return report;
}

}  // namespace t4d::convert
