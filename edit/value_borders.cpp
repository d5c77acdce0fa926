#include "edit/value_borders.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include "edit/cell_shape.h"
#include "model/cell_normal.h"
#include "t4d/mesh.h"

namespace t4d::edit {

using model::Attribute;
using model::Cell;
using model::Domain;

namespace {

/// The cell across from corner k of a cell.
std::optional<std::uint32_t> neighbourOf(const CellComplex& complex, std::uint32_t cell, int k) {
  const Cell& corners = complex.cells()[cell];
  std::optional<std::uint32_t> found;
  complex.eachCell(corners[(k + 1) % 4], [&](std::uint32_t near, int) {
    if (near == cell) return;
    const auto isCommon = [&](std::uint32_t corner) {
      return corner != corners[k] && hasCorner(corners, corner);
    };
    if (std::ranges::count_if(complex.cells()[near], isCommon) == 3) found = near;
  });
  return found;
}

/// Adds the hyperplane through the triangle opposite corner k that is perpendicular to the cell.
void addBorder(const Cell& cell, int k, Patch& patch) {
  constexpr double kBorderWeight = 100;
  const auto& at = patch.vertices;
  const Eigen::Vector4d normal = model::cellNormal(cornersOf(at, cell));
  const std::uint32_t p = cell[(k + 1) % 4];
  const Eigen::Vector4d across =
      model::crossProduct(normal, at[cell[(k + 2) % 4]] - at[p], at[cell[(k + 3) % 4]] - at[p]);
  if (!(across.norm() > 0)) return;
  for (int i = 1; i < 4; ++i) {
    patch.quadrics[cell[(k + i) % 4]].addHyperplane(across.normalized(),
                                                    kBorderWeight * normal.norm() / 6);
  }
}

}  // namespace

ValueBorders::ValueBorders(const CellComplex& complex, const Patch& patch,
                           const std::string& attribute)
    : complex_(complex) {
  if (attribute.empty()) return;
  const auto found = std::ranges::find_if(patch.attributes, [&](const Attribute& one) {
    return one.domain == Domain::Cell && one.name == attribute;
  });
  if (found != patch.attributes.end()) values_ = &*found;
}

void ValueBorders::weigh(Patch& patch) const {
  if (values_ == nullptr) return;
  for (std::uint32_t cell = 0; cell < patch.cells.size(); ++cell) {
    for (int k = 0; k < 4; ++k) {
      const auto near = neighbourOf(complex_, cell, k);
      if (near && !haveSameValue(cell, *near)) addBorder(patch.cells[cell], k, patch);
    }
  }
}

bool ValueBorders::stayIf(std::uint32_t a, std::uint32_t b) {
  if (values_ == nullptr) return true;
  const std::size_t ofA = valuesAround(a, model::kNoIndex);
  const std::size_t ofB = valuesAround(b, model::kNoIndex);
  if (ofA == 1 || ofB == 1) return true;
  return valuesAround(a, b) == std::min(ofA, ofB);
}

bool ValueBorders::haveSameValue(std::uint32_t one, std::uint32_t other) const {
  return std::memcmp(values_->row(one), values_->row(other), values_->rowBytes()) == 0;
}

/// The number of values of the cells around a vertex, or those of them that have another.
std::size_t ValueBorders::valuesAround(std::uint32_t vertex, std::uint32_t other) {
  around_.clear();
  complex_.eachCell(vertex, [&](std::uint32_t cell, int) {
    if (other != model::kNoIndex && !hasCorner(complex_.cells()[cell], other)) return;
    const auto same = [&](std::uint32_t one) { return haveSameValue(one, cell); };
    if (std::ranges::none_of(around_, same)) around_.push_back(cell);
  });
  return around_.size();
}

}  // namespace t4d::edit
