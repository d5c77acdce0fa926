#include "edit/carried_attributes.h"

#include <algorithm>
#include <map>

#include "model/attribute_rows.h"
#include "model/corner_attributes.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Domain;
using model::Triangle;

/// For each corner of `after`, the corner of `before` whose values it has: 3 * triangle + number.
std::vector<std::uint32_t> cornersFor(const std::vector<Triangle>& before,
                                      std::span<const Triangle> after,
                                      std::span<const std::uint32_t> sources) {
  std::map<Triangle, std::uint32_t> known;
  std::map<std::uint32_t, std::uint32_t> ofVertex;
  for (std::uint32_t i = 0; i < before.size(); ++i) {
    Triangle sorted = before[i];
    std::ranges::sort(sorted);
    known.try_emplace(sorted, i);
    for (std::uint32_t k = 0; k < 3; ++k) ofVertex.try_emplace(before[i][k], 3 * i + k);
  }
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * after.size());
  for (const Triangle& triangle : after) {
    const Triangle from{sources[triangle[0]], sources[triangle[1]], sources[triangle[2]]};
    Triangle sorted = from;
    std::ranges::sort(sorted);
    const auto found = known.find(sorted);
    for (const std::uint32_t vertex : from) {
      if (found == known.end()) {
        corners.push_back(ofVertex.at(vertex));
        continue;
      }
      const auto& corner = before[found->second];
      const auto at = std::ranges::find(corner, vertex) - corner.begin();
      corners.push_back(3 * found->second + static_cast<std::uint32_t>(at));
    }
  }
  return corners;
}

}  // namespace

std::vector<Attribute> carriedAttributes(const model::TriangleMesh& before,
                                         std::span<const Triangle> after,
                                         std::span<const std::uint32_t> sources) {
  if (before.attributes.empty()) return {};
  const auto corners = cornersFor(before.triangles, after, sources);
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 0; i < corners.size(); i += 3) triangles.push_back(corners[i] / 3);
  std::vector<Attribute> carried;
  for (const Attribute& attribute : before.attributes) {
    if (attribute.domain == Domain::Vertex) {
      carried.push_back(rowsOf(attribute, sources));
    } else if (attribute.name.ends_with(model::kCornersOf) && attribute.components % 3 == 0) {
      Attribute byCorner = attribute;
      byCorner.components /= 3;
      byCorner = rowsOf(byCorner, corners);
      byCorner.components *= 3;
      carried.push_back(std::move(byCorner));
    } else {
      carried.push_back(rowsOf(attribute, triangles));
    }
  }
  return carried;
}

}  // namespace t4d::edit
