#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "edit/cell_complex.h"
#include "edit/patch.h"

namespace t4d::edit {

/// The borders between cells of a patch that differ in an attribute, such as bodies, labels or
/// materials. The complex and the patch must outlive this object.
class ValueBorders {
 public:
  /// `attribute` is the name of a cell attribute; without such an attribute there are no borders.
  ValueBorders(const CellComplex& complex, const Patch& patch, const std::string& attribute);

  /// Adds penalties for moving a border to the quadrics of a patch. To be called before any
  /// collapse.
  void weigh(Patch& patch) const;

  /// Whether the edge is on every border that both of its ends are on, so that these borders stay
  /// if the ends join.
  bool stayIf(std::uint32_t a, std::uint32_t b);

 private:
  bool haveSameValue(std::uint32_t one, std::uint32_t other) const;
  std::size_t valuesAround(std::uint32_t vertex, std::uint32_t other);

  const CellComplex& complex_;
  const model::Attribute* values_ = nullptr;
  std::vector<std::uint32_t> around_;
};

}  // namespace t4d::edit
