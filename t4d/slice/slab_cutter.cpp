#include "t4d/slice/slab_cutter.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "t4d/slice/in_order.h"

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

  /// The points of `block` are at `positions`.
  void add(const model::CellBlock& block, const Cut& cut,
           const std::vector<model::Point3>& positions) {
    std::vector<std::uint32_t> number;
    for (std::size_t i = 0; i < cut.points.size(); ++i) {
      const auto [below, above] = cut.points[i];
      number.push_back(numbers_.of({block.numberInSlab(below), block.numberInSlab(above)}));
      if (number.back() == positions_.size()) positions_.push_back(positions[i]);
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
    return made;
  }

 private:
  std::shared_ptr<Cut> cut_ = std::make_shared<Cut>();
  std::vector<model::Point3> positions_;
  PointNumbers numbers_;
};

/// A block on its way through the threads.
struct BlockItem {
  model::CellBlock block;
  Cut cut;
  CutSlab placed;
  std::optional<Error> error;
};

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

SlabCutter::SlabCutter(const Hyperplane& hyperplane, OnHyperplane rule,
                       std::shared_ptr<CutMemory> memory)
    : hyperplane_(scaledHyperplane(hyperplane)),
      basis_(basisOf(hyperplane)),
      rule_(rule),
      memory_(std::move(memory)) {}

double SlabCutter::heightOf(const Point4& point) const {
  return along(hyperplane_.normal, point) - hyperplane_.offset;
}
bool SlabCutter::isAbove(double height) const {
  return rule_ == OnHyperplane::Above ? height >= 0 : height > 0;
}

SlabCutter::Heights SlabCutter::heightsOf(std::span<const Point4> vertices) const {
  Heights of{std::vector<double>(vertices.size()), std::vector<std::uint8_t>(vertices.size())};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double height = heightOf(vertices[i]);
    of.heights[i] = height;
    of.sides[i] = (isAbove(height) ? Side::kAbove : 0) | (height == 0 ? Side::kOn : 0);
  }
  return of;
}

/// Sets positions and fractions.
void SlabCutter::place(const Cut& cut, std::span<const Point4> vertices,
                       const std::vector<double>& heights, CutSlab& into) const {
  into.fractions.reserve(cut.points.size());
  into.positions.reserve(cut.points.size());
  for (const auto& [below, above] : cut.points) {
    const double drop = heights[below];
    const double fraction = below == above ? 0 : drop / (drop - heights[above]);
    const Point4 point = vertices[below] + fraction * (vertices[above] - vertices[below]);
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
  return isAbove(heightOf(lowest)) || !isAbove(heightOf(highest));
}

Result<CutSlab> SlabCutter::cut(const Slab& slab) const {
  if (auto checked = checkHyperplane(hyperplane_); !checked) return pass(checked.error());
  if (auto checked = memory_->check(slab.connectivity); !checked) return pass(checked.error());
  if (auto checked = checkSlab(slab); !checked) return pass(checked.error());
  auto [heights, sides] = heightsOf(slab.vertices);
  CutSlab made;
  made.counts = *slab.connectivity;
  made.slab = &slab;
  made.blocksRead = (slab.connectivity->cells.size() + kBlockCells - 1) / kBlockCells;
  made.cut = memory_->cut(slab.connectivity, std::move(sides));
  place(*made.cut, slab.vertices, heights, made);
  return made;
}

Result<CutSlab> SlabCutter::cut(const model::SlabBlocks& blocks) const {
  if (auto checked = checkHyperplane(hyperplane_); !checked) return pass(checked.error());
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
    place(cut->cut, block->vertices, heights, cut->placed);
    block->cells = {};
    block->vertices = {};
    cut->block = std::move(*block);
    return cut;
  };
  inOrder<std::shared_ptr<BlockItem>>(met.size(), item, [&](const auto& made) {
    if (made->error) {
      error = made->error;
      return false;
    }
    cuts.add(made->block, made->cut, made->placed.positions);
    return true;
  });
  if (error) return pass(*error);
  return cuts.finish(blocks, met.size());
}

Result<CutSlab> SlabCutter::cut(const OpenSlab& open) const {
  return open.blocks ? cut(*open.blocks) : cut(*open.slab);
}

Result<OpenSlab> openSlab(const model::Source& source, std::size_t index) {
  auto blocks = source.blocks(index);
  if (!blocks) return pass(blocks.error());
  if (*blocks) return OpenSlab{nullptr, std::move(*blocks)};
  auto slab = source.slab(index);
  if (!slab) return pass(slab.error());
  return OpenSlab{std::move(*slab), nullptr};
}

}  // namespace t4d::slice
