#include "edit/slice_topology.h"

#include <algorithm>
#include <array>

#include "t4d/mesh.h"

namespace t4d::edit {

using model::Cell;
using model::Point4;

bool SliceTopology::hasSphere(std::uint32_t vertex, bool remember) {
  const LinkSides sides = sidesAfter(vertex, model::kNoIndex, model::kNoIndex, 0);
  if (!counter_.isSphere()) return false;
  if (remember) sides_[vertex] = sides;
  return true;
}

bool SliceTopology::staysIf(std::uint32_t a, std::uint32_t b, const Point4& place) {
  if (sides_[a] && sides_[b]) {
    const LinkSides& expected = isCritical(b) ? *sides_[b] : *sides_[a];
    if (sidesAfter(a, a, b, place[3]) != expected) return false;
  }
  // Others change only if a or b moves from one side of them to the other.
  const auto [first, last] = std::minmax({vertices_[a][3], vertices_[b][3], place[3]});
  for (const std::uint32_t centre : {a, b}) {
    const auto near = complex_.neighbours(centre);
    const auto keeps = [&, first = first, last = last](std::uint32_t vertex) {
      const double time = vertices_[vertex][3];
      return time < first || time > last || vertex == a || vertex == b || !sides_[vertex] ||
             sidesAfter(vertex, a, b, place[3]) == *sides_[vertex];
    };
    if (!std::ranges::all_of(near, keeps)) return false;
  }
  return true;
}

/// The sides of a vertex once b has joined a, which then has this time.
LinkSides SliceTopology::sidesAfter(std::uint32_t vertex, std::uint32_t a, std::uint32_t b,
                                    double timeOfA) {
  const auto time = [&](std::uint32_t one) { return one == a ? timeOfA : vertices_[one][3]; };
  const double centre = time(vertex);
  const auto isBefore = [&](std::uint32_t one) {
    const double its = time(one);
    return its != centre ? its < centre : one < vertex;
  };
  counter_.clear();
  const auto addLink = [&](std::uint32_t around) {
    complex_.eachCell(around, [&](std::uint32_t cell, int k) {
      const Cell& corners = complex_.cells()[cell];
      if (a != b && hasCorner(corners, a) && hasCorner(corners, b)) return;
      std::array<std::uint32_t, 3> triangle{};
      for (int i = 1; i < 4; ++i) {
        const std::uint32_t corner = corners[(k + i) % 4];
        triangle[i - 1] = corner == b ? a : corner;
      }
      counter_.addTriangle(triangle, isBefore);
    });
  };
  addLink(vertex);
  if (vertex == a && b != a) addLink(b);
  return counter_.sides();
}

void SliceTopology::join(std::uint32_t a, std::uint32_t b) {
  if (!sides_[a] || !sides_[b]) {
    sides_[a].reset();
  } else if (isCritical(b)) {
    sides_[a] = sides_[b];
  }
}

}  // namespace t4d::edit
