#include "voxel4d/vdb_grid.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>

#include <fmt/format.h>
#include <openvdb/io/io.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/util/Name.h>

#include "model/parallel.h"
#include "voxel4d/frame_file.h"
#include "voxel4d/occupancy.h"
#include "voxel4d/vdb_voxel.h"

namespace t4d::voxel4d {

namespace {

/// Entries of a transform's matrix smaller than its scale times this are rounding errors.
constexpr double kTransformTolerance = 1e-12;

/// Which values of a grid are inside, and how they are converted to a field.
template <class Value>
struct Rule {
  double sign = 1;
  double iso = 0;

  bool inside(Value value) const {
    if constexpr (std::is_same_v<Value, bool>) return value;
    const auto number = static_cast<double>(value);
    return sign > 0 ? number < iso : number > iso;
  }
  double field(Value value) const {
    if constexpr (std::is_same_v<Value, bool>) return 0;
    return sign * (static_cast<double>(value) - iso);
  }
  static bool usable(Value value) {
    if constexpr (std::is_same_v<Value, bool>) return true;
    return std::isfinite(value);
  }
};

/// The inside points of a leaf node of a bool or mask grid, whose values are its active points.
template <class Leaf>
BlockMask maskOf(const Leaf& leaf) {
  BlockMask mask;
  for (unsigned i = 0; i < mask.size(); ++i) {
    if constexpr (std::is_same_v<typename Leaf::BuildType, openvdb::ValueMask>) {
      mask[i] = leaf.getValueMask().template getWord<std::uint64_t>(i);
    } else {
      mask[i] = leaf.buffer().data()[i];
    }
  }
  return mask;
}

/// The inside points of the values of a leaf node, and whether all are finite.
template <class Value>
bool maskOf(const Value* value, const Rule<Value>& rule, BlockMask& mask) {
  bool usable = true;
  for (std::uint64_t& word : mask) {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < 64; ++i, ++value) {
      bits |= std::uint64_t{rule.inside(*value)} << i;
      usable = usable && rule.usable(*value);
    }
    word = bits;
  }
  return usable;
}

Error notFinite(const Place& where, const openvdb::Coord& at) {
  return invalid(fmt::format("has values that are not finite, at or near the voxel ({}, {}, {})",
                             at.x(), at.y(), at.z()),
                 where);
}

/// Blocks covered by nodes of one level of a tree that are entirely inside.
template <class Node, class Value>
Result<void> addTiles(const std::vector<const Node*>& nodes, const Rule<Value>& rule,
                      const Place& where, std::vector<InsideTile>& tiles) {
  struct Found {
    std::vector<InsideTile> tiles;
    bool usable = true;
  };
  std::vector<Found> found(nodes.size());
  model::forEach(nodes.size(), [&](std::size_t i) {
    for (auto value = nodes[i]->cbeginValueAll(); value; ++value) {
      found[i].usable = found[i].usable && rule.usable(*value);
      if (!rule.inside(*value)) continue;
      found[i].tiles.push_back({blockAt(value.getCoord()),
                                static_cast<std::int32_t>(Node::ChildNodeType::DIM) / kBlockSize,
                                rule.field(*value)});
    }
  });
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!found[i].usable) return notFinite(where, nodes[i]->origin());
    tiles.insert(tiles.end(), found[i].tiles.begin(), found[i].tiles.end());
  }
  return {};
}

template <class Grid>
Result<Frame> frameOfGrid(const std::shared_ptr<const Grid>& grid,
                          const std::shared_ptr<const FrameFile>& file, double time,
                          const std::optional<double>& iso, bool below, const Place& where) {
  using Tree = typename Grid::TreeType;
  using Value = typename Grid::ValueType;
  using Leaf = typename Tree::LeafNodeType;
  using Root = typename Tree::RootNodeType;
  using Upper = typename Root::ChildNodeType;
  using Lower = typename Upper::ChildNodeType;
  constexpr bool kHasValues = !std::is_same_v<Value, bool>;
  static_assert(Leaf::SIZE == 512);

  const Tree& tree = grid->tree();
  Rule<Value> rule;
  if (iso) rule = {below ? 1.0 : -1.0, *iso};
  Frame frame;
  frame.time = time;
  if (file) {
    frame.file = file;
    frame.valueSizeInFile = sizeof(Value);
  } else {
    frame.owner = grid;
  }

  const Value background = tree.background();
  if (!rule.usable(background)) return invalid("has a background that is not finite", where);
  if (rule.inside(background)) {
    return invalid(
        kHasValues ? fmt::format("its background {} is inside: the solid would have no bounds{}",
                                 static_cast<double>(background),
                                 iso ? fmt::format(" (the iso value is {})", *iso) : "")
                   : "its background is true: the solid would have no bounds",
        where);
  }
  if constexpr (kHasValues) {
    // A background equal to the iso value is outside, if only just.
    frame.outsideValue = std::max(rule.field(background), std::numeric_limits<double>::min());
  }

  std::vector<const Leaf*> leaves;
  tree.getNodes(leaves);
  std::sort(leaves.begin(), leaves.end(),
            [](const Leaf* a, const Leaf* b) { return a->origin() < b->origin(); });
  frame.blocks.resize(leaves.size());
  std::vector<char> usable(leaves.size());
  model::forEach(leaves.size(), [&](std::size_t i) {
    Block& block = frame.blocks[i];
    const Leaf& leaf = *leaves[i];
    block.coord = blockAt(leaf.origin());
    if constexpr (kHasValues) {
      block.values.sign = rule.sign;
      block.values.iso = rule.iso;
      block.inFile = leaf.transientData();
      constexpr auto numbers = [] {
        if constexpr (std::is_same_v<Value, float>) return &BlockValues::floats;
        if constexpr (std::is_same_v<Value, double>) return &BlockValues::doubles;
      }();
      if (!file) block.values.*numbers = leaf.buffer().data();
      ValueBuffer buffer;
      const Value* const values = valuesOf(frame, i, buffer).*numbers;
      usable[i] = static_cast<char>(maskOf(values, rule, block.inside));
    } else {
      block.inside = maskOf(leaf);
      usable[i] = 1;
    }
  });
  if (file) {
    if (auto read = file->checkRead(); !read) {
      return fail(read.error().code, read.error().message, where);
    }
  }
  const auto bad = std::find(usable.begin(), usable.end(), char{0});
  if (bad != usable.end()) return notFinite(where, leaves[bad - usable.begin()]->origin());

  std::vector<const Lower*> lower;
  std::vector<const Upper*> upper;
  tree.getNodes(lower);
  tree.getNodes(upper);
  if (auto added = addTiles(lower, rule, where, frame.tiles); !added) return added.error();
  if (auto added = addTiles(upper, rule, where, frame.tiles); !added) return added.error();
  if (auto added = addTiles(std::vector<const Root*>{&tree.root()}, rule, where, frame.tiles);
      !added) {
    return added.error();
  }
  std::sort(frame.tiles.begin(), frame.tiles.end(),
            [](const InsideTile& a, const InsideTile& b) { return a.coord < b.coord; });

  const auto tooFar = [](const Coord& low, std::int32_t size) {
    constexpr std::int32_t kLimit = kMaxCoordinate / kBlockSize;
    const auto beyond = [&](std::int32_t from) { return from < -kLimit || from > kLimit - size; };
    return beyond(low.x) || beyond(low.y) || beyond(low.z);
  };
  std::optional<Coord> far;
  for (const Block& block : frame.blocks) {
    if (tooFar(block.coord, 1)) far = block.coord;
  }
  for (const InsideTile& tile : frame.tiles) {
    if (tooFar(tile.coord, tile.size)) far = tile.coord;
  }
  if (far) {
    return invalid(fmt::format("reaches the voxel ({}, {}, {}); coordinates must be below {}",
                               std::int64_t{8} * far->x, std::int64_t{8} * far->y,
                               std::int64_t{8} * far->z, kMaxCoordinate),
                   where);
  }
  return frame;
}

}  // namespace

Coord blockAt(const openvdb::Coord& point) {
  return {point.x() >> 3, point.y() >> 3, point.z() >> 3};
}

openvdb::Coord cornerOf(const Coord& block) {
  return {block.x * kBlockSize, block.y * kBlockSize, block.z * kBlockSize};
}

openvdb::math::Transform::Ptr transformBy(const openvdb::math::MapBase& map) {
  std::stringstream stored;
  openvdb::io::setCurrentVersion(stored);
  openvdb::writeString(stored, map.type());
  map.write(stored);
  auto transform = std::make_shared<openvdb::math::Transform>();
  transform->read(stored);
  return transform;
}

openvdb::math::Transform::Ptr transformOf(const Lattice& lattice) {
  openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
  for (int i = 0; i < 3; ++i) {
    matrix[i][i] = lattice.voxelSize < kFinestVoxel ? 1 : lattice.voxelSize;
    matrix[3][i] = lattice.origin[i];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

void initializeOpenVdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

std::string typeOf(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::MaskGrid>() ? "mask" : grid.valueType();
}

Result<GridKind> kindOf(const openvdb::GridBase& grid, const Place& where) {
  if (grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>()) {
    return GridKind::Values;
  }
  if (grid.isType<openvdb::BoolGrid>() || grid.isType<openvdb::MaskGrid>()) return GridKind::Mask;
  return invalid(fmt::format("is a grid of type {} ({}); float, double, bool and mask grids can be "
                             "used",
                             typeOf(grid), grid.type()),
                 where);
}

Result<Lattice> latticeOf(const openvdb::GridBase& grid, const Place& where) {
  const openvdb::math::MapBase& map = *grid.transform().baseMap();
  if (!map.isLinear()) {
    return invalid(fmt::format("its transform is a {}; only a uniform scale with a translation can "
                               "be used",
                               map.type()),
                   where);
  }
  // Its affine map would not exist for small voxels.
  openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
  matrix.setTranslation(map.applyMap(openvdb::Vec3d(0)));
  for (int i = 0; i < 3; ++i) {
    openvdb::Vec3d axis(0);
    axis[i] = 1;
    const openvdb::Vec3d row = map.applyJacobian(axis);
    for (int j = 0; j < 3; ++j) matrix[i][j] = row[j];
  }
  double scale = 0;
  bool finite = true;
  for (int i = 0; i < 3; ++i) {
    scale = std::max(scale, std::abs(matrix[i][i]));
    for (int j = 0; j < 4; ++j) finite = finite && std::isfinite(matrix[j][i]);
  }
  bool uniform = finite && scale > 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double expected = i == j ? matrix[0][0] : 0;
      uniform = uniform && std::abs(matrix[i][j] - expected) <= kTransformTolerance * scale;
    }
  }
  if (!uniform || matrix[0][0] <= 0) {
    const auto row = [&](int i) {
      return fmt::format("({:g}, {:g}, {:g})", matrix[i][0], matrix[i][1], matrix[i][2]);
    };
    return invalid(
        fmt::format("its transform takes a voxel's axes to {}, {}, {}; only a uniform scale with a "
                    "translation can be used: resample it",
                    row(0), row(1), row(2)),
        where);
  }
  return Lattice{matrix[0][0], {matrix[3][0], matrix[3][1], matrix[3][2]}};
}

Result<Frame> frameOf(const VdbGrid& whole, double time, const std::optional<double>& iso,
                      const Place& where, bool below) {
  const auto& [grid, values] = whole;
  if (auto kind = kindOf(*grid, where); !kind) return kind.error();
  if (auto floats = openvdb::gridConstPtrCast<openvdb::FloatGrid>(grid)) {
    return frameOfGrid(floats, values, time, iso, below, where);
  }
  if (auto doubles = openvdb::gridConstPtrCast<openvdb::DoubleGrid>(grid)) {
    return frameOfGrid(doubles, values, time, iso, below, where);
  }
  if (auto bools = openvdb::gridConstPtrCast<openvdb::BoolGrid>(grid)) {
    return frameOfGrid(bools, nullptr, time, {}, false, where);
  }
  return frameOfGrid(openvdb::gridConstPtrCast<openvdb::MaskGrid>(grid), nullptr, time, {}, false,
                     where);
}

openvdb::BoolGrid::Ptr boolGridOf(const Frame& frame, const Lattice& lattice) {
  auto grid = openvdb::BoolGrid::create(false);
  grid->setTransform(transformOf(lattice));
  openvdb::BoolTree& tree = grid->tree();
  for (const Block& block : frame.blocks) {
    auto leaf = std::make_unique<openvdb::BoolTree::LeafNodeType>(cornerOf(block.coord), false);
    for (unsigned i = 0; i < block.inside.size(); ++i) {
      leaf->buffer().data()[i] = block.inside[i];
      leaf->getValueMask().getWord<std::uint64_t>(i) = block.inside[i];
    }
    tree.addLeaf(leaf.release());
  }
  for (const InsideTile& tile : frame.tiles) {
    const openvdb::Coord corner = cornerOf(tile.coord);
    tree.sparseFill({corner, corner.offsetBy(tile.size * kBlockSize - 1)}, true, true);
  }
  openvdb::tools::pruneTiles(tree);
  return grid;
}

}  // namespace t4d::voxel4d
