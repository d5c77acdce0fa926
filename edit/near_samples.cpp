#include "edit/near_samples.h"

#include <algorithm>

#include "edit/cell_shape.h"

namespace t4d::edit {

using model::Cell;
using model::Point4;

NearSamples::NearSamples(std::vector<Sample> samples, std::size_t cellCount,
                         const measure::SliceBound* original)
    : original_(original),
      samples_(std::move(samples)),
      first_(cellCount, model::kNoIndex),
      next_(samples_.size(), model::kNoIndex) {
  for (std::uint32_t i = 0; i < samples_.size(); ++i) {
    next_[i] = first_[samples_[i].cell];
    first_[samples_[i].cell] = i;
  }
}

bool NearSamples::stayNear(const CellComplex& complex, std::span<const Point4> vertices,
                           std::uint32_t a, std::uint32_t b, const Point4& place, double distance) {
  remaining_.clear();
  emptied_.clear();
  moves_.clear();
  if (original_ == nullptr) return true;
  const auto addCells = [&](std::uint32_t centre, std::uint32_t other) {
    complex.eachCell(centre, [&](std::uint32_t cell, int k) {
      const Cell& corners = complex.cells()[cell];
      const bool isShared = hasCorner(corners, other);
      if (isShared && centre == b) return;  // seen around a
      emptied_.push_back(cell);
      if (isShared) return;
      auto points = cornersOf(vertices, corners);
      points[k] = place;
      const measure::SpaceTimeTetrahedron made(points);
      if (!measure::isAtOneTime(points)) remaining_.push_back({cell, made});
    });
  };
  addCells(a, b);
  addCells(b, a);
  if (remaining_.empty()) return true;
  if (!original_->isNear(place, distance) ||
      !areEdgesNear(complex, vertices, a, b, place, distance)) {
    return false;
  }
  for (const std::uint32_t cell : emptied_) {
    for (std::uint32_t i = first_[cell]; i != model::kNoIndex; i = next_[i]) {
      const std::uint32_t found = nearest(samples_[i].point, distance);
      if (found == model::kNoIndex) return false;
      moves_.push_back({i, found});
    }
  }
  return true;
}

bool NearSamples::areEdgesNear(const CellComplex& complex, std::span<const Point4> vertices,
                               std::uint32_t a, std::uint32_t b, const Point4& place,
                               double distance) {
  around_.clear();
  for (const Remaining& one : remaining_) {
    for (const std::uint32_t corner : complex.cells()[one.cell]) {
      if (corner == a || corner == b || std::ranges::find(around_, corner) != around_.end()) {
        continue;
      }
      around_.push_back(corner);
      if (!original_->isNear((place + vertices[corner]) / 2, distance)) return false;
    }
  }
  return true;
}

std::uint32_t NearSamples::nearest(const Point4& point, double distance) const {
  double least = distance * distance;
  std::uint32_t found = model::kNoIndex;
  for (const auto& [cell, tetrahedron] : remaining_) {
    const double squared = tetrahedron.squaredDistance(point, least);
    if (squared > least || (squared == least && found != model::kNoIndex)) continue;
    least = squared;
    found = cell;
    if (least == 0) break;
  }
  return found;
}

void NearSamples::move() {
  for (const std::uint32_t cell : emptied_) first_[cell] = model::kNoIndex;
  for (const auto& [sample, cell] : moves_) {
    samples_[sample].cell = cell;
    next_[sample] = first_[cell];
    first_[cell] = sample;
  }
}

}  // namespace t4d::edit
