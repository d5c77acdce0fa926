#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "t4d/edit/cell_complex.h"
#include "t4d/edit/link_sides.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

/// Where slices change their topology, and whether a collapse moves that: at vertices whose link
/// has other than one part before and one part after them (LinkSides). A cell complex and its
/// vertices are looked at, and must outlive it.
class SliceTopology {
 public:
  SliceTopology(const CellComplex& complex, std::span<const model::Point4> vertices)
      : complex_(complex),
        vertices_(vertices),
        sides_(vertices.size()),
        counter_(vertices.size()) {}

  /// Whether the link of a vertex is a sphere. Then its sides are remembered, if that is wanted.
  bool hasSphere(std::uint32_t vertex, bool remember);

  /// Whether slices change their topology at a vertex whose sides are remembered.
  bool isCritical(std::uint32_t vertex) const {
    return sides_[vertex] && !sides_[vertex]->isRegular();
  }

  /// Whether the vertices where the topology changes stay the same if a and b join at `place`.
  bool staysIf(std::uint32_t a, std::uint32_t b, const model::Point4& place);
  /// Before they do.
  void join(std::uint32_t a, std::uint32_t b);

 private:
  LinkSides sidesAfter(std::uint32_t vertex, std::uint32_t a, std::uint32_t b, double timeOfA);

  const CellComplex& complex_;
  std::span<const model::Point4> vertices_;
  std::vector<std::optional<LinkSides>> sides_;
  LinkSideCounter counter_;
};

}  // namespace t4d::edit
