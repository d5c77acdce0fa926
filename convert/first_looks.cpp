#include "convert/first_looks.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "t4d/slice.h"

namespace t4d::convert {
namespace {

std::string lossOf(const model::Attribute& attribute, const char* why) {
  return fmt::format("attribute '{}': {}", attribute.name, why);
}

/// Leaves out what does not stay right while the mesh moves, and tells of it.
void keepWhatStays(const std::vector<model::Attribute>& later,
                   const model::AttributeMeanings& meanings,
                   std::vector<model::Attribute>& attributes, std::vector<std::string>& losses) {
  std::erase_if(attributes, [&](const model::Attribute& attribute) {
    if (!model::isSpatial(model::meaningOf(attribute, meanings))) return false;
    losses.push_back(
        lossOf(attribute, "its values are directions or points, which would not move along"));
    return true;
  });
  for (const model::Attribute& attribute : attributes) {
    if (std::ranges::find(later, attribute) != later.end()) continue;
    losses.push_back(
        lossOf(attribute, "its values change over time, and are those of the first time"));
  }
}

}  // namespace

Result<std::vector<std::string>> addFirstLooks(const model::Body& body, const model::TimeSpan& span,
                                               const FlipbookOptions& options,
                                               formats::NamedMesh& mesh) {
  std::vector<std::string> losses;
  if (!options.paint && !options.write.attributes) return losses;
  const model::TimeSpan own = model::timeSpanOf({&body, 1});
  const double time = std::clamp(span.begin, own.begin, own.end);
  const slice::LightSlicer slicer(*body.source);
  auto first = slicer.at(time);
  if (!first) return first.error();
  const model::TriangleMesh& sliced = first->slice.mesh;
  const bool fits = mesh.mesh.triangles == sliced.triangles &&
                    mesh.mesh.vertices.size() == sliced.vertices.size();
  if (fits) mesh.mesh.attributes = sliced.attributes;
  mesh.ownCorners = fits && first->light;
  if (options.paint) options.paint(mesh, time);
  if (!options.write.attributes) return losses;
  losses = std::move(first->slice.losses);
  for (const model::Attribute& attribute : sliced.attributes) {
    if (fits) continue;
    losses.push_back(lossOf(attribute, "slices have other vertices or triangles than the body"));
  }
  auto last = slicer.at(std::clamp(span.end, own.begin, own.end));
  if (!last) return last.error();
  keepWhatStays(last->slice.mesh.attributes, options.meanings, mesh.mesh.attributes, losses);
  return losses;
}

}  // namespace t4d::convert
