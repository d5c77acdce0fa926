#include "t4d/edit/proved_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "t4d/edit/cell_complex.h"
#include "t4d/measure/slice_bound.h"
#include "t4d/measure/space_time_tree.h"

namespace t4d::edit {
namespace {

using measure::SliceBound;
using model::Bounds4;
using model::Cell;

/// Where more than this part of some cells is not near enough, samples are too far apart for their
/// distance: all is done again with a smaller one.
constexpr double kMostBad = 0.01;
constexpr double kSmallerReach = 0.75;

/// After so many, nothing is collapsed.
constexpr int kTries = 30;

/// A cell, told from others by its corners.
using PlacedCell = std::array<std::array<double, 4>, 4>;

PlacedCell placed(const std::vector<model::Point4>& vertices, const Cell& cell) {
  PlacedCell made{};
  for (int k = 0; k < 4; ++k) {
    const model::Point4& at = vertices[cell[k]];
    made[k] = {at[0], at[1], at[2], at[3]};
  }
  std::ranges::sort(made);
  return made;
}

std::vector<PlacedCell> placedCells(const Patch& patch) {
  std::vector<PlacedCell> all;
  all.reserve(patch.cells.size());
  for (const Cell& cell : patch.cells) all.push_back(placed(patch.vertices, cell));
  std::ranges::sort(all);
  return all;
}

bool isAmong(const std::vector<PlacedCell>& cells, const PlacedCell& one) {
  return std::ranges::binary_search(cells, one);
}

/// The cells with these numbers.
std::vector<Cell> someOf(const std::vector<Cell>& cells,
                         const std::vector<std::uint32_t>& numbers) {
  std::vector<Cell> some;
  some.reserve(numbers.size());
  for (const std::uint32_t number : numbers) some.push_back(cells[number]);
  return some;
}

Bounds4 boundsOf(const std::vector<model::Point4>& vertices, const Cell& cell) {
  Bounds4 bounds;
  for (const std::uint32_t corner : cell) bounds.add(vertices[corner]);
  return bounds;
}

/// What is proved of a patch after another one: only what they have not in common is looked at.
class NearnessProof {
 public:
  /// All of the patch given is near enough.
  NearnessProof(const Patch& given, const Original& original, const SliceBound& toOriginal,
                double maxError)
      : original_(original),
        toOriginal_(toOriginal),
        maxError_(maxError),
        cells_(placedCells(given)) {}

  /// Which vertices of a patch have a cell, or are near an original one, that is not proved.
  std::vector<bool> unproved(const Patch& patch) {
    std::vector<PlacedCell> now = placedCells(patch);
    std::vector<bool> isBad(patch.vertices.size());
    std::vector<Cell> changed;
    for (const Cell& cell : patch.cells) {
      const PlacedCell one = placed(patch.vertices, cell);
      if (!isAmong(cells_, one) || isAmong(bad_, one)) changed.push_back(cell);
    }
    bad_.clear();
    for (const std::uint32_t i : toOriginal_.notProvedNear({patch.vertices, changed}, maxError_)) {
      bad_.push_back(placed(patch.vertices, changed[i]));
      for (const std::uint32_t corner : changed[i]) isBad[corner] = true;
    }
    std::ranges::sort(bad_);
    const std::vector<std::uint32_t> asked = originalsNear(gone(now));
    const SliceBound toPatch({patch.vertices, patch.cells});
    const std::vector<Cell> answered = someOf(original_.cells, asked);
    lost_.clear();
    for (const std::uint32_t i : toPatch.notProvedNear({original_.vertices, answered}, maxError_)) {
      lost_.push_back(asked[i]);
    }
    markNear(patch, isBad);
    cells_ = std::move(now);
    return isBad;
  }

 private:
  /// The cells of the last patch that are not in this one.
  std::vector<Bounds4> gone(const std::vector<PlacedCell>& now) const {
    std::vector<Bounds4> bounds;
    for (const PlacedCell& one : cells_) {
      if (isAmong(now, one)) continue;
      Bounds4& its = bounds.emplace_back();
      for (const auto& corner : one) its.add(model::Point4(corner.data()));
    }
    return bounds;
  }

  /// The original cells whose proof may need a cell that is no more, and those without one.
  std::vector<std::uint32_t> originalsNear(std::vector<Bounds4> boxes) const {
    const measure::SpaceTimeTree tree(std::move(boxes));
    std::vector<std::uint32_t> near = lost_;
    for (std::uint32_t i = 0; i < original_.cells.size(); ++i) {
      const Bounds4 bounds = boundsOf(original_.vertices, original_.cells[i]);
      if (!std::ranges::binary_search(lost_, i) &&
          tree.anyNear(bounds, maxError_, [](std::uint32_t) { return true; })) {
        near.push_back(i);
      }
    }
    std::ranges::sort(near);
    return near;
  }

  /// Marks the vertices of the cells of the patch that are nearest to those lost, or nearly so.
  void markNear(const Patch& patch, std::vector<bool>& isBad) const {
    if (lost_.empty()) return;
    std::vector<Bounds4> bounds;
    for (const Cell& cell : patch.cells) bounds.push_back(boundsOf(patch.vertices, cell));
    const measure::SpaceTimeTree tree(std::move(bounds));
    for (const std::uint32_t i : lost_) {
      const Bounds4 box = boundsOf(original_.vertices, original_.cells[i]);
      bool isFound = false;
      for (double distance = maxError_; !isFound && std::isfinite(distance); distance *= 2) {
        tree.anyNear(box, distance, [&](std::uint32_t near) {
          isFound = true;
          for (const std::uint32_t corner : patch.cells[near]) isBad[corner] = true;
          return false;
        });
      }
    }
  }

  const Original& original_;
  const SliceBound& toOriginal_;
  double maxError_;
  std::vector<PlacedCell> cells_;    // of the last patch, in order
  std::vector<PlacedCell> bad_;      // those of them that are not proved
  std::vector<std::uint32_t> lost_;  // original cells without a proof
};

/// Whether too many cells of a patch are farther from the original than the largest error.
bool isMostlyFar(const Patch& patch, const SliceBound& toOriginal, double maxError) {
  constexpr std::size_t kEach = 64;
  std::vector<Cell> some;
  for (std::size_t i = 0; i < patch.cells.size(); i += kEach) some.push_back(patch.cells[i]);
  const auto far = toOriginal.notProvedNear({patch.vertices, some}, maxError);
  return static_cast<double>(far.size()) > 1 + kMostBad * static_cast<double>(some.size());
}

/// Marks the vertices that have a cell in common with one that is marked. Returns whether there are
/// any.
bool markNeighbours(const Patch& patch, std::vector<bool>& isMarked) {
  const std::vector<bool> before = isMarked;
  for (const Cell& cell : patch.cells) {
    if (std::ranges::none_of(cell, [&](std::uint32_t v) { return before[v]; })) continue;
    for (const std::uint32_t corner : cell) isMarked[corner] = true;
  }
  return isMarked != before;
}

/// The collapses without the last `count` of those that made each vertex that is bad or, if none of
/// these was made, of those around them.
std::vector<Collapse> withoutLast(const CollapsedPatch& made, std::vector<bool> isBad,
                                  std::uint32_t count) {
  const auto isOfBad = [&](const Collapse& one) { return isBad[made.vertexOf[one.a]]; };
  while (std::ranges::none_of(made.collapses, isOfBad)) {
    if (!markNeighbours(made.patch, isBad)) return {};
  }
  std::vector<std::uint32_t> dropped(isBad.size());
  std::vector<Collapse> kept;
  for (auto one = made.collapses.rbegin(); one != made.collapses.rend(); ++one) {
    if (isOfBad(*one) && dropped[made.vertexOf[one->a]]++ < count) continue;
    kept.push_back(*one);
  }
  std::ranges::reverse(kept);
  return kept;
}

}  // namespace

Original originalOf(const Patch& patch) { return {patch.vertices, patch.cells}; }

Original joined(Original one, const Original& other) {
  const auto shift = static_cast<std::uint32_t>(one.vertices.size());
  one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Cell& cell : other.cells) {
    one.cells.push_back({cell[0] + shift, cell[1] + shift, cell[2] + shift, cell[3] + shift});
  }
  return one;
}

Patch provedCollapse(const Patch& given, const Original& original, double maxError,
                     const CollapseOptions& options) {
  const SliceBound toOriginal({original.vertices, original.cells});
  CollapseOptions near = options;
  near.original = &toOriginal;
  NearnessProof proof(given, original, toOriginal, maxError);
  Patch start = given;
  CollapsedPatch made = collapsed(start, near);
  if (isMostlyFar(made.patch, toOriginal, maxError)) {
    for (double& reach : start.reaches) reach *= kSmallerReach;
    made = collapsed(start, near);
  }
  for (int i = 0; i < kTries; ++i) {
    const std::vector<bool> isBad = proof.unproved(made.patch);
    if (std::ranges::find(isBad, true) == isBad.end()) return std::move(made.patch);
    const std::vector<Collapse> fewer =
        withoutLast(made, isBad, std::uint32_t{1} << std::min(i, 20));
    near.only = &fewer;
    made = collapsed(start, near);
  }
  return given;
}

}  // namespace t4d::edit
