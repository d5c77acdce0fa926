#include "measure/space_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "model/parallel.h"
#include "model/progress.h"
#include "model/voxel_size.h"

namespace t4d::measure {

std::vector<std::uint64_t> allCornersOf(std::span<const std::uint64_t> cubes) {
  std::vector<std::uint64_t> points;
  points.reserve(8 * cubes.size());
  for (const std::uint64_t cube : cubes) {
    for (unsigned corner = 0; corner < 8; ++corner) {
      points.push_back(keyOf(cornerOf(indexOf(cube), corner)));
    }
  }
  std::ranges::sort(points);
  points.erase(std::ranges::unique(points).begin(), points.end());
  points.shrink_to_fit();
  return points;
}

Result<SpaceLattice> SpaceLattice::about(const model::Bounds3& bounds, double spacing) {
  SpaceLattice lattice;
  lattice.spacing = spacing;
  for (int axis = 0; axis < 3; ++axis) {
    const double least = bounds.min[axis];
    const double most = bounds.max[axis];
    const double cells = most / spacing - least / spacing;
    if (!(cells < kMostPoints - 3)) {
      return model::tooManyVoxels(spacing, cells, kMostPoints);
    }
    const double whole = std::floor(cells);
    const auto count = static_cast<std::uint32_t>(cells - whole < 0.5 ? whole + 1 : whole + 2);
    const double middle = 0.5 * least + 0.5 * most;
    std::vector<double>& at = lattice.at[axis];
    for (std::uint32_t i = 0; i <= count; ++i) at.push_back(middle + (i - 0.5 * count) * spacing);
    // Places within a cell have to be told apart, too.
    constexpr double kSteps = 1024;
    const double largest = std::max(std::abs(at.front()), std::abs(at.back()));
    const double step = std::nextafter(largest, std::numeric_limits<double>::infinity()) - largest;
    if (!(spacing > kSteps * step) || !(at.front() < least && at.back() > most)) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("a voxel size of {} is too small for coordinates of {:.6g}, which are "
                      "rounded to multiples of {:.3g}",
                      spacing, largest, step),
          {}, Remedy::VoxelSize);
    }
  }
  return lattice;
}

/// The number of the first point that does not come before a place. Searched for near the place
/// that the spacing gives, which rounding moves by a point at most.
template <class ComesBefore>
std::uint32_t SpaceLattice::firstNear(int axis, double value, ComesBefore comesBefore) const {
  const std::vector<double>& points = at[axis];
  const double last = static_cast<double>(points.size());
  const double steps = std::clamp((value - points.front()) / spacing, 0.0, last);
  auto number = static_cast<std::uint32_t>(steps);
  while (number > 0 && !comesBefore(points[number - 1])) --number;
  while (number < points.size() && comesBefore(points[number])) ++number;
  return number;
}

std::uint32_t SpaceLattice::firstFrom(int axis, double value) const {
  return firstNear(axis, value, [value](double point) { return point < value; });
}

std::uint32_t SpaceLattice::firstAfter(int axis, double value) const {
  return firstNear(axis, value, [value](double point) { return point <= value; });
}

Result<std::vector<std::uint64_t>> cubesThatMeet(
    const SpaceLattice& lattice,
    const std::function<bool(const LatticeIndex& low, std::uint32_t size)>& mayMeet,
    const model::Progress& progress) {
  std::uint32_t size = 1;
  for (const auto& at : lattice.at) {
    size = std::max(size, std::bit_ceil(static_cast<std::uint32_t>(at.size() - 1)));
  }
  std::vector<std::uint64_t> blocks = {0};
  for (;; size /= 2) {
    std::vector<std::uint8_t> meets(blocks.size());
    // Nearly all of the work is that of the last rounds.
    const model::Progress shown = size == 1   ? model::partOf(progress, 0.5, 1)
                                  : size == 2 ? model::partOf(progress, 0, 0.5)
                                              : model::Progress();
    const auto done = model::forEach(blocks.size(), shown, [&](std::size_t i) {
      meets[i] = mayMeet(indexOf(blocks[i]), size) ? 1 : 0;
    });
    if (!done) return done.error();
    std::vector<std::uint64_t> next;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (meets[i] == 0) continue;
      if (size == 1) {
        next.push_back(blocks[i]);
        continue;
      }
      const LatticeIndex low = indexOf(blocks[i]);
      for (unsigned corner = 0; corner < 8; ++corner) {
        LatticeIndex child = low;
        bool exists = true;
        for (int axis = 0; axis < 3; ++axis) {
          child[axis] += (corner >> axis & 1) * size / 2;
          exists = exists && child[axis] + 1 < lattice.at[axis].size();
        }
        if (exists) next.push_back(keyOf(child));
      }
    }
    blocks = std::move(next);
    if (size == 1) break;
  }
  std::ranges::sort(blocks);
  return blocks;
}

}  // namespace t4d::measure
