#include "slice/slab_cutter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "model/parallel.h"
#include "slice/prisms.h"
#include "slice/surface_motion.h"

namespace t4d::slice {
namespace {

using model::Point4;
using model::Slab;
using model::Triangle;

/// A slab that is cut block by block.
class BlockCuts {
 public:
  explicit BlockCuts(const model::SlabBlocks& blocks)
      : numbers_(blocks.vertexCount, cut_->points) {}

  /// `placed` has the positions of the points of `block`, and the speeds of its triangles.
  void add(const model::CellBlock& block, const Cut& cut, const CutSlab& placed) {
    const std::vector<double>& speeds = placed.motion.speeds;
    speeds_.insert(speeds_.end(), speeds.begin(), speeds.end());
    std::vector<std::uint32_t> number;
    for (std::size_t i = 0; i < cut.points.size(); ++i) {
      const auto [below, above] = cut.points[i];
      number.push_back(numbers_.of({block.numberInSlab(below), block.numberInSlab(above)}));
      if (number.back() == positions_.size()) positions_.push_back(placed.positions[i]);
    }
    for (const Triangle& triangle : cut.triangles) {
      cut_->triangles.push_back({number[triangle[0]], number[triangle[1]], number[triangle[2]]});
    }
  }

  CutSlab finish(const model::SlabBlocks& blocks, std::uint64_t blocksRead) {
    CutSlab made;
    made.counts = blocks;
    made.blocksRead = blocksRead;
    for (const std::uint32_t i : numberAsInSlab(*cut_)) made.positions.push_back(positions_[i]);
    made.cut = std::move(cut_);
    made.motion.speeds = std::move(speeds_);
    return made;
  }

 private:
  std::shared_ptr<Cut> cut_ = std::make_shared<Cut>();
  std::vector<model::Point3> positions_;
  std::vector<double> speeds_;  // of each triangle, if the motion is asked for
  PointNumbers numbers_;
};

/// A block on its way through the threads.
struct BlockItem {
  model::CellBlock block;
  Cut cut;
  CutSlab placed;
  std::optional<Error> error;
};

/// The support of cells, as in CellRuns::supports.
std::array<std::uint32_t, CellRuns::kSupport> supportOf(const model::Connectivity& connectivity,
                                                        std::span<const model::Cell> cells) {
  std::set<std::uint32_t> support;
  const model::Means& means = connectivity.means;
  for (const model::Cell& cell : cells) {
    for (const std::uint32_t vertex : cell) {
      if (vertex < connectivity.firstMean() || vertex >= connectivity.firstUpper()) {
        support.insert(vertex);
        continue;
      }
      const std::uint32_t mean = vertex - connectivity.firstMean();
      support.insert(means.sources.begin() + means.offsets[mean],
                     means.sources.begin() + means.offsets[mean + 1]);
    }
  }
  std::array<std::uint32_t, CellRuns::kSupport> found{};
  if (support.empty() || support.size() > found.size()) {
    found[0] = CellRuns::kUnknown;
    return found;
  }
  found.fill(*support.begin());
  std::ranges::copy(support, found.begin());
  return found;
}

}  // namespace

Result<void> CutMemory::check(const std::shared_ptr<const model::Connectivity>& connectivity) {
  if (!connectivity) return {};  // refused by checkSlab
  {
    const std::scoped_lock lock(mutex_);
    if (connectivity == checked_) return {};
  }
  if (auto checked = checkConnectivity(*connectivity); !checked) return checked;
  const std::scoped_lock lock(mutex_);
  checked_ = connectivity;
  return {};
}

std::shared_ptr<const Cut> CutMemory::cut(
    const std::shared_ptr<const model::Connectivity>& connectivity,
    std::vector<std::uint8_t> sides) {
  {
    const std::scoped_lock lock(mutex_);
    if (connectivity == connectivity_ && sides == sides_) return last_;
  }
  auto made = std::make_shared<const Cut>(cutOf(connectivity->cells, sides));
  const std::scoped_lock lock(mutex_);
  connectivity_ = connectivity;
  sides_ = std::move(sides);
  last_ = made;
  return made;
}

std::shared_ptr<const CellRuns> CutMemory::runs(
    const std::shared_ptr<const model::Connectivity>& connectivity) {
  return *runs_.get(connectivity.get(), [&]() -> Result<CellRuns> {
    CellRuns runs{connectivity, {}};
    const std::vector<model::Cell>& cells = connectivity->cells;
    for (std::size_t begin = 0; begin < cells.size(); begin += CellRuns::kRunCells) {
      const std::size_t count = std::min<std::size_t>(CellRuns::kRunCells, cells.size() - begin);
      runs.supports.push_back(supportOf(*connectivity, std::span(cells).subspan(begin, count)));
    }
    return runs;
  });
}

bool CutMemory::hasPrisms(const std::shared_ptr<const model::Connectivity>& connectivity) {
  return **prisms_.get(connectivity.get(),
                       [&]() -> Result<bool> { return prismsOf(*connectivity).has_value(); });
}

SlabCutter::SlabCutter(const Hyperplane& hyperplane, OnHyperplane rule,
                       std::shared_ptr<CutMemory> memory, WithMotion withMotion)
    : hyperplane_(scaledHyperplane(hyperplane)),
      basis_(basisOf(hyperplane)),
      rule_(rule),
      memory_(std::move(memory)),
      withMotion_(withMotion) {}

double SlabCutter::heightOf(const Point4& point) const {
  return along(hyperplane_.normal, point) - hyperplane_.offset;
}
bool SlabCutter::isAbove(double height) const {
  return rule_ == OnHyperplane::Above ? height >= 0 : height > 0;
}

std::uint8_t SlabCutter::sideOf(double height) const {
  return (isAbove(height) ? Side::kAbove : 0) | (height == 0 ? Side::kOn : 0);
}

SlabCutter::Heights SlabCutter::heightsOf(std::span<const Point4> vertices) const {
  Heights of{std::vector<double>(vertices.size()), std::vector<std::uint8_t>(vertices.size())};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    of.heights[i] = heightOf(vertices[i]);
    of.sides[i] = sideOf(of.heights[i]);
  }
  return of;
}

/// Sets positions and fractions.
template <class VertexAt>
void SlabCutter::place(const Cut& cut, VertexAt vertexAt, const std::vector<double>& heights,
                       CutSlab& into) const {
  into.fractions.reserve(cut.points.size());
  into.positions.reserve(cut.points.size());
  for (const auto& [below, above] : cut.points) {
    const double drop = heights[below];
    const double fraction = below == above ? 0 : drop / (drop - heights[above]);
    const Point4 from = vertexAt(below);
    const Point4 point = from + fraction * (vertexAt(above) - from);
    into.fractions.push_back(fraction);
    into.positions.emplace_back(basis_.axes * point);
  }
}

bool SlabCutter::misses(const model::Bounds4& bounds) const {
  if (bounds.empty() || !checkHyperplane(hyperplane_)) return false;
  Point4 lowest = bounds.min;
  Point4 highest = bounds.max;
  for (int k = 0; k < 4; ++k) {
    if (hyperplane_.normal[k] < 0) std::swap(lowest[k], highest[k]);
  }
  // The height of infinite coordinates may be no number: the slab is then read, and refused.
  const double height = heightOf(highest);
  return isAbove(heightOf(lowest)) || (!std::isnan(height) && !isAbove(height));
}

Result<CutSlab> SlabCutter::cut(const Slab& slab) const {
  if (auto checked = checkHyperplane(hyperplane_); !checked) return checked.error();
  if (auto checked = memory_->check(slab.connectivity); !checked) return checked.error();
  if (auto checked = checkSlab(slab); !checked) return checked.error();
  auto [heights, sides] = heightsOf(slab.vertices);
  CutSlab made;
  made.counts = *slab.connectivity;
  for (const auto& attribute : slab.connectivity->cellAttributes) {
    made.attributes.push_back(&attribute);
  }
  for (const auto& attribute : slab.attributes) made.attributes.push_back(&attribute);
  made.blocksRead = (slab.connectivity->cells.size() + kBlockCells - 1) / kBlockCells;
  made.cut = memory_->cut(slab.connectivity, std::move(sides));
  place(
      *made.cut, [&](std::uint32_t i) -> const Point4& { return slab.vertices[i]; }, heights, made);
  if (withMotion_ == WithMotion::Yes) {
    made.motion.speeds = speedsOf(*made.cut, slab.connectivity->cells, slab.vertices);
    if (memory_->hasPrisms(slab.connectivity)) {
      made.motion.velocities = velocitiesOf(*made.cut, made.fractions, slab);
    }
  }
  return made;
}

/// More than what rounding changes in the height of a vertex or of a mean.
double SlabCutter::roundingOf(const model::LayeredSlab& slab) const {
  Point4 largest = Point4::Zero();
  const auto add = [&](const std::vector<Point4>& vertices) {
    for (const Point4& vertex : vertices) largest = largest.cwiseMax(vertex.cwiseAbs());
  };
  add(*slab.lower);
  add(slab.interior);
  add(*slab.upper);
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  return kRounding * (hyperplane_.normal.cwiseAbs().dot(largest) + std::abs(hyperplane_.offset));
}

/// The heights of means are set where they are needed.
Cut SlabCutter::cutRuns(const model::LayeredSlab& slab, const CellRuns& runs, Heights& of) const {
  const model::Connectivity& connectivity = *slab.connectivity;
  const std::vector<model::Cell>& cells = connectivity.cells;
  const double rounding = roundingOf(slab);
  constexpr std::uint8_t kUnset = 0xff;
  std::fill(of.sides.begin() + connectivity.firstMean(),
            of.sides.begin() + connectivity.firstUpper(), kUnset);
  const auto isClear = [&](const std::array<std::uint32_t, CellRuns::kSupport>& support) {
    if (support[0] == CellRuns::kUnknown) return false;
    double lowest = of.heights[support[0]];
    double highest = lowest;
    for (const std::uint32_t vertex : support) {
      lowest = std::min(lowest, of.heights[vertex]);
      highest = std::max(highest, of.heights[vertex]);
    }
    return lowest > rounding || highest < -rounding;
  };
  CellCutter cutter(cells, of.sides);
  for (std::size_t run = 0; run < runs.supports.size(); ++run) {
    if (isClear(runs.supports[run])) continue;
    const auto begin = static_cast<std::uint32_t>(run * CellRuns::kRunCells);
    const auto end =
        std::min(begin + CellRuns::kRunCells, static_cast<std::uint32_t>(cells.size()));
    for (std::uint32_t i = begin; i < end; ++i) {
      for (const std::uint32_t vertex : cells[i]) {
        if (of.sides[vertex] != kUnset) continue;
        of.heights[vertex] = heightOf(slab.vertex(vertex));
        of.sides[vertex] = sideOf(of.heights[vertex]);
      }
    }
    cutter.add(begin, end);
  }
  return cutter.finish();
}

Result<CutSlab> SlabCutter::cut(const model::LayeredSlab& slab) const {
  if (auto checked = checkHyperplane(hyperplane_); !checked) return checked.error();
  const model::Connectivity& connectivity = *slab.connectivity;
  Heights of{std::vector<double>(connectivity.vertexCount),
             std::vector<std::uint8_t>(connectivity.vertexCount)};
  const auto set = [&](const std::vector<Point4>& vertices, std::uint32_t first) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      of.heights[first + i] = heightOf(vertices[i]);
      of.sides[first + i] = sideOf(of.heights[first + i]);
    }
  };
  set(*slab.lower, 0);
  set(slab.interior, connectivity.lowerCount);
  set(*slab.upper, connectivity.firstUpper());
  CutSlab made;
  made.counts = connectivity;
  for (const auto& attribute : connectivity.cellAttributes) made.attributes.push_back(&attribute);
  for (const auto& attribute : slab.cellAttributes) made.attributes.push_back(&attribute);
  made.blocksRead = (connectivity.cells.size() + kBlockCells - 1) / kBlockCells;
  const auto runs = memory_->runs(slab.connectivity);
  made.cut = std::make_shared<const Cut>(cutRuns(slab, *runs, of));
  place(
      *made.cut, [&](std::uint32_t i) { return slab.vertex(i); }, of.heights, made);
  return made;
}

Result<CutSlab> SlabCutter::cut(const model::SlabBlocks& blocks) const {
  if (auto checked = checkHyperplane(hyperplane_); !checked) return checked.error();
  std::vector<std::size_t> met;
  for (std::size_t i = 0; i < blocks.blockCount(); ++i) {
    if (!misses(blocks.bounds(i))) met.push_back(i);
  }
  BlockCuts cuts(blocks);
  std::optional<Error> error;
  const auto item = [&](std::size_t i) -> std::shared_ptr<BlockItem> {
    auto cut = std::make_shared<BlockItem>();
    auto block = blocks.read(met[i]);
    if (!block) {
      cut->error = block.error();
      return cut;
    }
    const auto [heights, sides] = heightsOf(block->vertices);
    cut->cut = cutOf(block->cells, sides);
    place(
        cut->cut, [&](std::uint32_t k) -> const Point4& { return block->vertices[k]; }, heights,
        cut->placed);
    if (withMotion_ == WithMotion::Yes) {
      cut->placed.motion.speeds = speedsOf(cut->cut, block->cells, block->vertices);
    }
    block->cells = {};
    block->vertices = {};
    cut->block = std::move(*block);
    return cut;
  };
  model::inOrder<std::shared_ptr<BlockItem>>(met.size(), item, [&](const auto& made) {
    if (made->error) {
      error = made->error;
      return false;
    }
    cuts.add(made->block, made->cut, made->placed);
    return true;
  });
  if (error) return *error;
  return cuts.finish(blocks, met.size());
}

Result<CutSlab> SlabCutter::cut(const OpenSlab& open) const {
  if (open.layered) return cut(*open.layered);
  return open.blocks ? cut(*open.blocks) : cut(*open.slab);
}

Result<OpenSlab> openSlab(const model::Source& source, std::size_t index) {
  auto blocks = source.blocks(index);
  if (!blocks) return blocks.error();
  if (*blocks) return OpenSlab{nullptr, std::move(*blocks), nullptr};
  auto slab = source.slab(index);
  if (!slab) return slab.error();
  return OpenSlab{std::move(*slab), nullptr, nullptr};
}

Result<OpenSlab> openPartly(const model::Source& source, std::size_t index) {
  auto layered = source.layered(index);
  if (!layered) return layered.error();
  if (*layered) return OpenSlab{nullptr, nullptr, std::move(*layered)};
  return openSlab(source, index);
}

}  // namespace t4d::slice
