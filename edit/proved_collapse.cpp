#include "edit/proved_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "edit/cell_complex.h"
#include "edit/cell_shape.h"
#include "measure/slice_bound.h"
#include "measure/space_time_tetrahedron.h"
#include "model/box_tree.h"

namespace t4d::edit {
namespace {

using measure::SliceBound;
using model::Bounds4;
using model::Cell;

/// Where more than this part of some cells is not near enough, samples are too far apart for their
/// distance: all is done again with a smaller one.
constexpr double kMostBad = 0.01;
constexpr double kSmallerReach = 0.75;

/// After this many tries, nothing is collapsed.
constexpr int kTries = 30;

/// So many tries leave out the same number of collapses; the next, twice as many.
constexpr int kTriesOfCount = 3;

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

/// What is proved of one patch after another, all made from one that is near enough: only what they
/// have not in common is looked at.
class NearnessProof {
 public:
  /// The whole of the patch given must be near enough.
  NearnessProof(const Patch& given, const Original& original, const SliceBound& toOriginal,
                double maxError)
      : original_(original),
        toOriginal_(toOriginal),
        maxError_(maxError),
        given_(placedCells(given)),
        last_(given_) {}

  /// The cells of a patch that are not proved, and those nearest to an original one that is not.
  std::vector<Cell> failures(const Patch& patch) {
    std::vector<Cell> failed = cellsNotProved(patch);
    std::vector<PlacedCell> now = placedCells(patch);
    const std::vector<std::uint32_t> asked = originalsToProve(now);
    const SliceBound toPatch({patch.vertices, patch.cells});
    const std::vector<Cell> cells = someOf(original_.cells, asked);
    lost_.clear();
    for (const std::uint32_t i : toPatch.notProvedNear({original_.vertices, cells}, maxError_)) {
      lost_.push_back(asked[i]);
    }
    addNearestToLost(patch, failed);
    std::ranges::sort(failed);
    failed.erase(std::unique(failed.begin(), failed.end()), failed.end());
    last_ = std::move(now);
    return failed;
  }

 private:
  std::vector<Cell> cellsNotProved(const Patch& patch) {
    std::vector<Cell> asked;
    for (const Cell& cell : patch.cells) {
      const PlacedCell one = placed(patch.vertices, cell);
      const bool isProved = isAmong(given_, one) || (isAmong(last_, one) && !isAmong(bad_, one));
      if (!isProved) asked.push_back(cell);
    }
    std::vector<Cell> failed =
        someOf(asked, toOriginal_.notProvedNear({patch.vertices, asked}, maxError_));
    bad_.clear();
    for (const Cell& cell : failed) bad_.push_back(placed(patch.vertices, cell));
    std::ranges::sort(bad_);
    return failed;
  }

  /// A tree over the cells of a patch that are not in the one now.
  static model::BoxTree<4> gone(const std::vector<PlacedCell>& before,
                                const std::vector<PlacedCell>& now) {
    std::vector<Bounds4> bounds;
    for (const PlacedCell& one : before) {
      if (isAmong(now, one)) continue;
      Bounds4& its = bounds.emplace_back();
      for (const auto& corner : one) its.add(model::Point4(corner.data()));
    }
    return model::BoxTree<4>(std::move(bounds));
  }

  /// The original cells whose proof may need a cell that is no more, both of the patch given and of
  /// the last, if there was one in the last.
  std::vector<std::uint32_t> originalsToProve(const std::vector<PlacedCell>& now) const {
    const auto ofGiven = gone(given_, now);
    const auto ofLast = gone(last_, now);
    const auto isNear = [&](const model::BoxTree<4>& tree, const Bounds4& bounds) {
      return tree.anyOverlapping(model::widened(bounds, maxError_),
                                 [](std::uint32_t) { return true; });
    };
    std::vector<std::uint32_t> asked;
    for (std::uint32_t i = 0; i < original_.cells.size(); ++i) {
      const Bounds4 bounds = measure::boundsOf(cornersOf(original_.vertices, original_.cells[i]));
      const bool wasLost = std::ranges::binary_search(lost_, i);
      if ((wasLost || isNear(ofLast, bounds)) && isNear(ofGiven, bounds)) asked.push_back(i);
    }
    return asked;
  }

  /// Adds the cell of the patch that is nearest to the middle of each original one lost.
  void addNearestToLost(const Patch& patch, std::vector<Cell>& failed) const {
    if (lost_.empty()) return;
    std::vector<Bounds4> bounds;
    for (const Cell& cell : patch.cells)
      bounds.push_back(measure::boundsOf(cornersOf(patch.vertices, cell)));
    const model::BoxTree<4> tree(std::move(bounds));
    for (const std::uint32_t i : lost_) {
      const auto corners = cornersOf(original_.vertices, original_.cells[i]);
      const model::Point4 middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
      const Cell* nearest = nullptr;
      for (double reach = maxError_; nearest == nullptr && std::isfinite(reach); reach *= 2) {
        double least = std::numeric_limits<double>::infinity();
        tree.visitOverlapping(model::widened({middle, middle}, reach), [&](std::uint32_t near) {
          const measure::SpaceTimeTetrahedron cell(cornersOf(patch.vertices, patch.cells[near]));
          const double squared = cell.squaredDistance(middle, least);
          if (nearest == nullptr || squared < least) nearest = &patch.cells[near];
          least = std::min(least, squared);
        });
      }
      if (nearest != nullptr) failed.push_back(*nearest);
    }
  }

  const Original& original_;
  const SliceBound& toOriginal_;
  double maxError_;
  std::vector<PlacedCell> given_;    // in order
  std::vector<PlacedCell> last_;     // of the last patch, in order
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

/// For each vertex, the numbers of the cells that have it.
std::vector<std::vector<std::uint32_t>> cellsAt(const std::vector<Cell>& cells,
                                                std::size_t vertexCount) {
  std::vector<std::vector<std::uint32_t>> at(vertexCount);
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t corner : cells[i]) at[corner].push_back(i);
  }
  return at;
}

/// The cells of a patch that have a vertex in common with one of these.
std::vector<Cell> around(const Patch& patch, const std::vector<Cell>& cells) {
  const auto at = cellsAt(cells, patch.vertices.size());
  std::vector<Cell> all;
  std::ranges::copy_if(patch.cells, std::back_inserter(all), [&](const Cell& cell) {
    return std::ranges::any_of(cell, [&](std::uint32_t corner) { return !at[corner].empty(); });
  });
  return all;
}

/// The collapses without the last `count` of those that made the corners of each cell that failed
/// or, if none of these was made, of those around them.
std::vector<Collapse> withoutLast(const CollapsedPatch& made, std::vector<Cell> failed,
                                  std::uint32_t count) {
  auto failedAt = cellsAt(failed, made.patch.vertices.size());
  const auto failedOf = [&](const Collapse& one) -> const auto& {
    return failedAt[made.vertexOf[one.a]];
  };
  const auto isOfNone = [&](const Collapse& one) { return failedOf(one).empty(); };
  while (std::ranges::all_of(made.collapses, isOfNone)) {
    std::vector<Cell> more = around(made.patch, failed);
    if (more.size() == failed.size()) return {};
    failed = std::move(more);
    failedAt = cellsAt(failed, made.patch.vertices.size());
  }
  std::vector<std::uint32_t> dropped(failed.size());
  std::vector<Collapse> kept;
  for (auto one = made.collapses.rbegin(); one != made.collapses.rend(); ++one) {
    const auto& cells = failedOf(*one);
    if (std::ranges::any_of(cells, [&](std::uint32_t i) { return dropped[i] < count; })) {
      for (const std::uint32_t i : cells) ++dropped[i];
    } else {
      kept.push_back(*one);
    }
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
    const std::vector<Cell> failed = proof.failures(made.patch);
    if (failed.empty()) return std::move(made.patch);
    const std::vector<Collapse> fewer =
        withoutLast(made, failed, std::uint32_t{1} << (i / kTriesOfCount));
    near.only = &fewer;
    made = collapsed(start, near);
  }
  return given;
}

}  // namespace t4d::edit
