#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "model/error.h"
#include "model/geometry.h"
#include "model/layer_pose.h"

namespace t4d::voxel4d {

/// A lattice point, or a block of 8 x 8 x 8 of them (its points divided by 8, rounded down).
struct Coord {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend auto operator<=>(const Coord&, const Coord&) = default;  // NOLINT(modernize-use-nullptr)
};

struct CoordHash {
  std::size_t operator()(const Coord& c) const {
    std::uint64_t hash = static_cast<std::uint32_t>(c.x) * 0x9E3779B97F4A7C15U;
    hash = (hash ^ static_cast<std::uint32_t>(c.y)) * 0xC2B2AE3D27D4EB4FU;
    hash = (hash ^ static_cast<std::uint32_t>(c.z)) * 0x165667B19E3779F9U;
    return static_cast<std::size_t>(hash ^ hash >> 29U);
  }
};

/// One bit for each of a block's 512 points: word x, bit 8 y + z. This is OpenVDB's order of the
/// values of a leaf node, index 64 x + 8 y + z.
using BlockMask = std::array<std::uint64_t, 8>;

inline constexpr std::uint64_t kAllBits = ~std::uint64_t{0};
inline constexpr std::int32_t kBlockSize = 8;

/// The scalar field of a block, negative inside: float or double values of its 512 points in the
/// order of BlockMask, or none (bool and mask grids; surfaces then lie at the midpoints). Points to
/// memory kept alive by the frame's `owner`.
struct BlockValues {
  const float* floats = nullptr;
  const double* doubles = nullptr;
  double sign = 1;  ///< the field is sign * (value - iso)
  double iso = 0;

  bool empty() const { return floats == nullptr && doubles == nullptr; }
  double at(unsigned index) const {
    return sign * ((floats != nullptr ? static_cast<double>(floats[index]) : doubles[index]) - iso);
  }
};

/// Room for the values of a block.
using ValueBuffer = std::array<double, 512>;

/// 512 points that are partly inside, or that have values.
struct Block {
  Coord coord = {};  ///< in units of blocks
  BlockMask inside{};
  BlockValues values = {};   ///< may be empty; see valuesOf for those in a file
  std::uint32_t inFile = 0;  ///< the number of its values there
};

/// Frames with as many bytes of values or more keep them in a temporary file (TMPDIR says where)
/// instead of in memory.
inline constexpr std::size_t kLargeFrame = std::size_t{64} << 20U;

class FrameFile;
class SampleField;

/// A cube of points that are all inside: `size` blocks along each axis, starting with the block
/// `coord`. Frame::blocks has no blocks within it.
struct InsideTile {
  Coord coord = {};       ///< in units of blocks, a multiple of `size`
  std::int32_t size = 1;  ///< a power of two
  double value = 0;       ///< of the field, negative; 0 without values
};

/// The solid at one time on a lattice: blocks near its surface and tiles deep inside. All other
/// points are outside.
struct Frame {
  double time = 0;
  std::vector<Block> blocks = {};          ///< increasing by coord
  std::vector<InsideTile> tiles = {};      ///< disjoint; increasing by coord
  double outsideValue = 0;                 ///< of the field where nothing is stored; 0: no values
  std::shared_ptr<const void> owner = {};  ///< of the memory that BlockValues point to
  /// Where the values of all blocks are, if they are not in memory, and the bytes of each: of
  /// BlockValues only `sign` and `iso` are set.
  std::shared_ptr<const FrameFile> file = {};
  std::size_t valueSizeInFile = 0;
  /// The field, if it is one of dense samples (sample_box.h): BlockValues are empty then.
  std::shared_ptr<const SampleField> samples = {};

  bool hasValues() const { return outsideValue != 0; }
};

/// Fails if `frame` cannot be woven, and names the block or tile at fault: a time or a value that
/// is not finite; blocks or tiles that are out of order, overlap, or lie beyond 32-bit lattice
/// coordinates; a tile whose size is not a power of two or whose coordinates are not multiples of
/// it; values that are missing, or that contradict the bits or the tiles about what is inside.
Result<void> checkFrame(const Frame& frame);

/// Fails if doubles are too coarse for a frame whose lattice points `place` maps to space: if a
/// voxel is not between model::kSmallestExtent and model::kLargestCoordinate wide, or if what is
/// inside is more than 2^28 voxels from the origin of space, along any axis of the lattice.
Result<void> checkPlace(const Frame& frame, const model::Affine3x4& place);

/// The values of block number i, wherever they are, as long as `buffer` is left alone.
BlockValues valuesOf(const Frame& frame, std::size_t i, ValueBuffer& buffer);

/// The bytes of a value, if all blocks have values of one type; else 0.
std::size_t valueSizeOf(const Frame& frame);

/// Moves values that are in memory, of one type, to a file, and lets go of their owner.
Result<void> moveValuesToFile(Frame& frame);

/// The number of lattice points inside.
std::uint64_t countInside(const Frame& frame);

/// Maps lattice points to space: origin + voxelSize * point, the same along every axis.
struct Lattice {
  double voxelSize = 1;  ///< length units
  model::Point3 origin = model::Point3::Zero();

  model::Point3 operator()(const Eigen::Vector3d& point) const {
    return origin + voxelSize * point;
  }
  /// One coordinate of a lattice point in space.
  double along(int axis, double index) const { return origin[axis] + voxelSize * index; }
  /// The map from index space to space: (voxelSize I | origin).
  model::Affine3x4 place() const {
    model::Affine3x4 map;
    map << voxelSize * Eigen::Matrix3d::Identity(), origin;
    return map;
  }
  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// Provides frames in time order, with one in memory at a time.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const Lattice& lattice() const = 0;
  virtual std::size_t frameCount() const = 0;
  /// The place of errors about a frame: its number, or its file.
  virtual Place placeOf(std::size_t index) const;
  /// Whether nothing says how long it is from frame to frame, so that they are taken as 1 apart.
  virtual bool isOneApart() const { return false; }
  /// A notice on the frames once all have been requested; "" for none.
  virtual std::string notice() const { return {}; }
  /// Announces that only some consecutive frames will be requested: they may be empty.
  virtual void readsPart() {}
  /// Called once for each frame, or for some in a row (readsPart), in order.
  virtual Result<Frame> frame(std::size_t index) = 0;
};

}  // namespace t4d::voxel4d
