#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "t4d/edit/cell_complex.h"
#include "t4d/edit/patch.h"

namespace t4d::edit {

/// The borders between cells of a patch that differ in an attribute: bodies, labels, materials. The
/// complex and the patch must outlive it.
class ValueBorders {
 public:
  /// Of a cell attribute with this name; there are no borders if the patch has none.
  ValueBorders(const CellComplex& complex, const Patch& patch, const std::string& attribute);

  /// Adds to the quadrics of a patch, before any collapse, what penalises moving a border.
  void weigh(Patch& patch) const;

  /// Whether the edge lies on all borders that both of its ends lie on, so that they stay if the
  /// ends join.
  bool stayIf(std::uint32_t a, std::uint32_t b);

 private:
  bool haveSameValue(std::uint32_t one, std::uint32_t other) const;
  std::size_t valuesAround(std::uint32_t vertex, std::uint32_t other);

  const CellComplex& complex_;
  const model::Attribute* values_ = nullptr;
  std::vector<std::uint32_t> around_;
};

}  // namespace t4d::edit
