#include "voxel4d/vdb_tree.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <openvdb/io/Compression.h>

namespace t4d::voxel4d {

namespace {

namespace io = openvdb::io;

/// The header of a block compressed by Blosc (README_CHUNK_FORMAT.rst of c-blosc).
struct BloscHeader {
  std::array<std::uint8_t, 4> versions;
  std::uint32_t bytes = 0;
  std::uint32_t blockBytes = 0;
  std::uint32_t compressedBytes = 0;
};

/// Numbers as stored: raw, or as a block preceded by its size, which is negative if the block is
/// not compressed after all.
class PackedBytes {
 public:
  PackedBytes(VdbStream& stream, std::uint32_t compression)
      : stream_(stream), compression_(compression) {}

  void read(char* into, std::size_t size) {
    const bool blosc = (compression_ & io::COMPRESS_BLOSC) != 0;
    if (!blosc && (compression_ & io::COMPRESS_ZIP) == 0) {
      stream_.need(size);
      stream_.bytes(into, size);
      return;
    }
    const std::int64_t begin = stream_.position();
    const auto stored = stream_.take<std::int64_t>();
    if (stored <= 0) {
      require(stored == -static_cast<std::int64_t>(size),
              "is damaged: it announces {} values' bytes where there are {}", stored, size);
    } else {
      stream_.need(static_cast<std::uint64_t>(stored));
      if (blosc) judgeBlosc(stored, size);
    }
    stream_.seek(begin);
    if (blosc) {
      io::bloscFromStream(stream_.stream(), into, size);
    } else {
      io::unzipFromStream(stream_.stream(), into, size);
    }
  }

 private:
  void judgeBlosc(std::int64_t stored, std::size_t size) {
    stream_.need(sizeof(BloscHeader));
    const auto header = stream_.take<BloscHeader>();
    require(header.bytes == size && header.compressedBytes == stored,
            "is damaged: a block of {} bytes for {} says that it has {} for {}", stored, size,
            header.compressedBytes, header.bytes);
  }

  VdbStream& stream_;
  std::uint32_t compression_;
};

template <class Tree>
class TreeReader {
  using Root = typename Tree::RootNodeType;
  using Upper = typename Root::ChildNodeType;
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Tree::ValueType;
  static constexpr bool kIsMask = std::is_same_v<typename Tree::BuildType, openvdb::ValueMask>;
  static constexpr bool kIsBool = std::is_same_v<Value, bool>;
  /// A bool may be stored as any byte.
  using Stored = std::conditional_t<kIsBool, std::uint8_t, Value>;

 public:
  TreeReader(VdbStream& stream, const VdbCoding& coding, const VdbTreeOptions& options)
      : stream_(stream), coding_(coding), options_(options), packed_(stream, coding.compression) {}

  VdbTree read() {
    const auto buffers = stream_.take<std::int32_t>();
    require(buffers == 1, "is damaged: its tree has {} buffers", buffers);
    background_ = takeValue();
    auto tree = std::make_shared<Tree>(valueOf(background_));
    readRoot(tree->root());
    std::unique_ptr<FrameFile> file;
    const auto used = static_cast<std::size_t>(
        std::ranges::count_if(leaves_, [this](const Leaf* leaf) { return isUsed(*leaf); }));
    if (!kIsBool && used * Leaf::SIZE * sizeof(Value) >= options_.largeTree) {
      file = orThrow(FrameFile::create());
    }
    openvdb::Index32 number = 0;
    for (Leaf* const leaf : leaves_) {
      leaf->setTransientData(number);
      if (isUsed(*leaf)) ++number;
      readLeafValues(*leaf, file.get());
    }
    const std::uint64_t activeVoxels = tree->activeVoxelCount();
    if (options_.region) {
      clip(tree->root());
      if (file) moveNewValues(*tree, number, *file);
    }
    return {tree, std::move(file), activeVoxels};
  }

 private:
  void readRoot(Root& root) {
    const auto tiles = stream_.take<std::uint32_t>();
    const auto children = stream_.take<std::uint32_t>();
    // Both are in coordinate order.
    std::optional<openvdb::Coord> before;
    for (std::uint32_t i = 0; i < tiles; ++i) {
      const openvdb::Coord corner = takeCorner(before);
      const Stored value = takeValue();
      root.addTile(corner, valueOf(value), takeFlag());
    }
    before.reset();
    for (std::uint32_t i = 0; i < children; ++i) {
      root.addChild(readNode<Upper>(takeCorner(before)).release());
    }
    require(root.getTableSize() == std::size_t{tiles} + children,
            "is damaged: it has a tile and a node in one place");
  }

  template <class Node>
  std::unique_ptr<Node> readNode(const openvdb::Coord& corner) {
    using Child = typename Node::ChildNodeType;
    using Mask = typename Node::NodeMaskType;
    stream_.need(2 * Mask::memUsage());
    Mask children;
    Mask active;
    children.load(stream_.stream());
    active.load(stream_.stream());
    std::vector<Stored> values(Node::NUM_VALUES);
    readValues(values, active);
    auto node = std::make_unique<Node>(corner, valueOf(background_));
    for (openvdb::Index i = 0; i < Node::NUM_VALUES; ++i) {
      const bool on = active.isOn(i);
      if (on || values[i] != background_) node->addTile(i, valueOf(values[i]), on);
    }
    for (auto child = children.beginOn(); child; ++child) {
      require(!active.isOn(child.pos()),
              "is damaged: it has an active tile and a node in one place");
      const openvdb::Coord at = node->offsetToGlobalCoord(child.pos());
      if constexpr (std::is_same_v<Child, Leaf>) {
        node->addChild(readLeaf(at).release());
      } else {
        node->addChild(readNode<Child>(at).release());
      }
    }
    return node;
  }

  /// Reads where the values of a leaf node are active; the values follow after all nodes.
  std::unique_ptr<Leaf> readLeaf(const openvdb::Coord& corner) {
    const auto active = takeLeafMask();
    // It has no memory for values, which are all read later.
    auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), corner, valueOf(background_));
    for (auto on = active.beginOn(); on; ++on) leaf->setActiveState(on.pos(), true);
    leaves_.push_back(leaf.get());
    return leaf;
  }

  /// Reads the values of a leaf; numbers go into the file if there is one.
  void readLeafValues(Leaf& leaf, FrameFile* file) {
    const auto active = takeLeafMask();
    require(active == leaf.getValueMask(),
            "is damaged: a node's values are not active where its mask says so");
    if constexpr (kIsBool) {
      require(takeCoord() == leaf.origin(), "is damaged: a node's values are those of another");
      if constexpr (!kIsMask) {
        const auto values = takeLeafMask();
        for (auto on = values.beginOn(); on; ++on) leaf.setValueOnly(on.pos(), true);
      }
    } else if (file != nullptr || !isUsed(leaf)) {
      std::array<Stored, Leaf::SIZE> values;
      readValues(std::span<Stored>(values), active);
      if (!isUsed(leaf)) return;
      clipValues(leaf, values);
      orThrow(file->append(std::as_bytes(std::span(values))));
    } else {
      const std::span<Stored> values(leaf.buffer().data(), Leaf::SIZE);
      readValues(values, active);
      clipValues(leaf, values);
    }
  }

  /// Sets what is outside the region to the background. OpenVDB's own clip() also divides tiles of
  /// the background, and prunes, for which all values must be in memory.
  template <class Node>
  void clip(Node& node) const {
    struct Tile {
      openvdb::CoordBBox box;
      Value value;
      bool active;
    };
    const openvdb::CoordBBox& region = *options_.region;
    std::vector<Tile> cut;
    for (auto tile = node.cbeginValueAll(); tile; ++tile) {
      const openvdb::Coord corner = tile.getCoord();
      const openvdb::CoordBBox box(corner, corner.offsetBy(Node::ChildNodeType::DIM - 1));
      if (*tile == valueOf(background_) || region.isInside(box)) continue;
      cut.push_back({box, *tile, tile.isValueOn()});
    }
    std::vector<openvdb::Coord> outside;
    for (auto child = node.beginChildOn(); child; ++child) {
      const openvdb::CoordBBox box = child->getNodeBoundingBox();
      if (!region.hasOverlap(box)) {
        outside.push_back(box.min());
      } else if (!region.isInside(box)) {
        clip(*child);
      }
    }
    for (const openvdb::Coord& at : outside)
      node.addTile(Node::LEVEL, at, valueOf(background_), false);
    for (auto& [box, value, active] : cut) {
      node.addTile(Node::LEVEL, box.min(), valueOf(background_), false);
      box.intersect(region);
      if (!box.empty()) node.fill(box, value, active);
    }
  }
  void clip(Leaf& leaf) const { leaf.clip(*options_.region, valueOf(background_)); }

  /// Tiles that were partly in the region have become leaf nodes, with their values in memory.
  static void moveNewValues(Tree& tree, openvdb::Index32 number, FrameFile& file) {
    if constexpr (!kIsBool) {
      for (auto leaf = tree.beginLeaf(); leaf; ++leaf) {
        if (leaf->buffer().empty()) continue;
        leaf->setTransientData(number++);
        orThrow(file.append(std::as_bytes(std::span(leaf->buffer().data(), Leaf::SIZE))));
      }
    }
  }

  bool isUsed(const Leaf& leaf) const {
    return !options_.region || options_.region->hasOverlap(leaf.getNodeBoundingBox());
  }

  /// Sets values outside the region to the background.
  void clipValues(const Leaf& leaf, std::span<Stored> values) const {
    if (!options_.region || options_.region->isInside(leaf.getNodeBoundingBox())) return;
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
      if (!options_.region->isInside(leaf.offsetToGlobalCoord(i))) values[i] = background_;
    }
  }

  /// The values of a node, of which some inactive ones may not be stored: those have the
  /// background's value or one of two others.
  template <class Mask>
  void readValues(std::span<Stored> into, const Mask& active) {
    enum Inactive : std::uint8_t {
      kBackground = 0,
      kMinusBackground = 1,
      kOne = 2,
      kMaskOfBackgrounds = 3,
      kMaskOfBackgroundAndOne = 4,
      kMaskOfTwo = 5,
      kStored = 6,
    };
    const auto inactive = stream_.take<std::uint8_t>();
    require(inactive <= kStored, "is damaged: its inactive values are stored in the way {}",
            inactive);
    std::array<Stored, 2> off = {inactive == kBackground ? background_ : minus(background_),
                                 background_};
    if (inactive == kOne || inactive == kMaskOfBackgroundAndOne || inactive == kMaskOfTwo) {
      off[0] = takeValue();
    }
    if (inactive == kMaskOfTwo) off[1] = takeValue();
    Mask second;
    if (inactive >= kMaskOfBackgrounds && inactive <= kMaskOfTwo) second.load(stream_.stream());

    const bool allStored =
        (coding_.compression & io::COMPRESS_ACTIVE_MASK) == 0 || inactive == kStored;
    if (allStored) {
      readNumbers(into);
      return;
    }
    std::vector<Stored> stored(active.countOn());
    readNumbers(stored);
    auto next = stored.begin();
    for (openvdb::Index i = 0; i < into.size(); ++i) {
      into[i] = active.isOn(i) ? *next++ : off[second.isOn(i) ? 1 : 0];
    }
  }

  void readNumbers(std::span<Stored> into) {
    if constexpr (!kIsBool) {
      if (coding_.half) {
        if (into.empty()) return;  // then not even a size is stored
        using Half = typename io::RealToHalf<Value>::HalfT;
        std::vector<Half> halves(into.size());
        packed_.read(reinterpret_cast<char*>(halves.data()), halves.size() * sizeof halves[0]);
        std::transform(halves.begin(), halves.end(), into.begin(),
                       [](const Half& half) { return Value(half); });
        return;
      }
    }
    packed_.read(reinterpret_cast<char*>(into.data()), into.size_bytes());
    if constexpr (kIsBool) {
      for (const Stored value : into) judgeFlag(value);
    }
  }

  auto takeLeafMask() {
    typename Leaf::NodeMaskType mask;
    mask.load(stream_.stream());
    return mask;
  }

  openvdb::Coord takeCoord() {
    std::array<std::int32_t, 3> numbers{};
    stream_.bytes(numbers.data(), sizeof numbers);
    return openvdb::Coord(numbers.data());
  }

  /// Reads the corner of a child of the root.
  openvdb::Coord takeCorner(std::optional<openvdb::Coord>& before) {
    const openvdb::Coord corner = takeCoord();
    for (int axis = 0; axis < 3; ++axis) {
      require(corner[axis] % static_cast<std::int32_t>(Upper::DIM) == 0,
              "is damaged: it has a node at ({}, {}, {})", corner.x(), corner.y(), corner.z());
    }
    require(!before || *before < corner, "is damaged: its nodes are not in order");
    before = corner;
    return corner;
  }

  static void judgeFlag(std::uint8_t flag) {
    require(flag <= 1, "is damaged: {} stands for true or false", flag);
  }
  bool takeFlag() {
    const auto flag = stream_.take<std::uint8_t>();
    judgeFlag(flag);
    return flag == 1;
  }
  Stored takeValue() {
    const auto value = stream_.take<Stored>();
    if constexpr (kIsBool) judgeFlag(value);
    return value;
  }
  static Value valueOf(Stored value) { return static_cast<Value>(value); }
  static Stored minus(Stored value) {
    if constexpr (kIsBool) {
      return value == 0 ? 1 : 0;
    } else if constexpr (std::is_integral_v<Stored>) {
      return static_cast<Stored>(-static_cast<std::int64_t>(value));
    } else {
      return -value;
    }
  }

  VdbStream& stream_;
  VdbCoding coding_;
  VdbTreeOptions options_;
  PackedBytes packed_;
  Stored background_{};
  std::vector<Leaf*> leaves_;  // in the order in which they are stored
};

using Read = VdbTree (*)(VdbStream&, const VdbCoding&, const VdbTreeOptions&);

template <class Tree>
VdbTree read(VdbStream& stream, const VdbCoding& coding, const VdbTreeOptions& options) {
  return TreeReader<Tree>(stream, coding, options).read();
}

Read readerOf(const std::string& treeType) {
  if (treeType == openvdb::FloatTree::treeType()) return read<openvdb::FloatTree>;
  if (treeType == openvdb::DoubleTree::treeType()) return read<openvdb::DoubleTree>;
  if (treeType == openvdb::Int32Tree::treeType()) return read<openvdb::Int32Tree>;
  if (treeType == openvdb::BoolTree::treeType()) return read<openvdb::BoolTree>;
  if (treeType == openvdb::MaskTree::treeType()) return read<openvdb::MaskTree>;
  if (treeType == openvdb::Vec3STree::treeType()) return read<openvdb::Vec3STree>;
  return nullptr;
}

}  // namespace

bool canReadVdbTree(const std::string& treeType) { return readerOf(treeType) != nullptr; }

VdbTree readVdbTree(VdbStream& stream, const std::string& treeType, const VdbCoding& coding,
                    const VdbTreeOptions& options) {
  return readerOf(treeType)(stream, coding, options);
}

}  // namespace t4d::voxel4d
