#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "edit/cell_complex.h"
#include "edit/link_sides.h"
#include "t4d/mesh.h"

namespace t4d::edit {

/// Finds the vertices where slices change their topology, and whether a collapse changes these.
/// They are the vertices whose link does not have exactly one part before and one part after them
/// (LinkSides). The cell complex and its vertices must outlive this object.
class SliceTopology {
 public:
  SliceTopology(const CellComplex& complex, std::span<const model::Point4> vertices)
      : complex_(complex),
        vertices_(vertices),
        sides_(vertices.size()),
        counter_(vertices.size()) {}

  /// Whether the link of a vertex is a sphere. If so, and with `remember`, stores its LinkSides.
  bool hasSphere(std::uint32_t vertex, bool remember);

  /// Whether slices change their topology at a vertex, from its stored LinkSides.
  bool isCritical(std::uint32_t vertex) const {
    return sides_[vertex] && !sides_[vertex]->isRegular();
  }

  /// Whether the vertices where the topology changes stay the same if a and b join at `place`.
  bool staysIf(std::uint32_t a, std::uint32_t b, const model::Point4& place);
  /// Updates the stored data; to be called before a and b are joined.
  void join(std::uint32_t a, std::uint32_t b);

 private:
  LinkSides sidesAfter(std::uint32_t vertex, std::uint32_t a, std::uint32_t b, double timeOfA);

  const CellComplex& complex_;
  std::span<const model::Point4> vertices_;
  std::vector<std::optional<LinkSides>> sides_;
  LinkSideCounter counter_;
};

}  // namespace t4d::edit
