#pragma once

/// Voxels over time, the input of the voxel method: of arrays, of a function, of files.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

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

/// Whole numbers from `begin` up to, but not including, `end`. Without one of them, the range is
/// open on that side.
struct IndexRange {
  std::optional<std::int64_t> begin = {};
  std::optional<std::int64_t> end = {};
};

/// The part of frames that is used. Everything beyond it is outside.
struct Region {
  std::array<IndexRange, 3> space = {};  ///< lattice points along x, y and z
  IndexRange time = {};                  ///< frames, counted from 0
};

/// Reads "X0:X1,Y0:Y1,Z0:Z1" or "X0:X1,Y0:Y1,Z0:Z1,T0:T1", in which numbers may be left out. Fails
/// for ranges that are empty or reversed.
Result<Region> parseRegion(std::string_view text);

/// A range of what is counted from 0.
struct Extent {
  std::uint64_t begin = 0;
  std::uint64_t count = 0;
};

/// What a region's range along `axis` ('x', 'y', 'z' or 't') takes of `count` samples or frames.
/// Fails unless it is within them and, of frames, takes two or more. `where` is for errors.
Result<Extent> extentOf(const IndexRange& range, char axis, std::uint64_t count,
                        const std::string& where);

/// Leaves of a vector what an extent within it takes.
template <class Thing>
void keep(std::vector<Thing>& things, const Extent& extent) {
  things.erase(things.begin() + static_cast<std::ptrdiff_t>(extent.begin + extent.count),
               things.end());
  things.erase(things.begin(), things.begin() + static_cast<std::ptrdiff_t>(extent.begin));
}

/// One frame as an array in memory: the value at lattice point (x, y, z) of nx x ny x nz points is
/// values[(x * ny + y) * nz + z].
template <class T>
struct ArrayFrame {
  double time = 0;
  std::span<const T> values = {};
};

struct ArrayOptions {
  std::array<std::size_t, 3> size = {0, 0, 0};  ///< nx, ny, nz, the same for all frames
  Lattice lattice = {};                         ///< its origin is the position of point (0, 0, 0)
  /// Values above this are inside. Without it, values below zero are.
  std::optional<double> iso = {};
};

/// Frames for `weave` from arrays of float or double values, or of bools that are true inside.
/// Everything beyond the arrays is outside. An array is read when its frame is requested, so the
/// arrays must outlive the source.
///
/// Fails for a size of zero or of more than 2^31 - 1 points along an axis, an array of another
/// length, a value that is not finite, a voxel size that is not positive, `iso` with bools, and
/// values that differ from `iso` by too little for T.
template <class T>
Result<std::unique_ptr<FrameSource>> arrayFrames(std::span<const ArrayFrame<T>> frames,
                                                 const ArrayOptions& options);

extern template Result<std::unique_ptr<FrameSource>> arrayFrames<float>(
    std::span<const ArrayFrame<float>> frames, const ArrayOptions& options);
extern template Result<std::unique_ptr<FrameSource>> arrayFrames<double>(
    std::span<const ArrayFrame<double>> frames, const ArrayOptions& options);
extern template Result<std::unique_ptr<FrameSource>> arrayFrames<bool>(
    std::span<const ArrayFrame<bool>> frames, const ArrayOptions& options);

/// The field of a solid: negative inside, at a point of space and a time.
using FieldFunction = std::function<double(const model::Point3& point, double time)>;

/// Frames for `weave` from a function: `field` at each of `times` and at each of `size` lattice
/// points, of which (0, 0, 0) lies at the origin of the lattice. Everything beyond them is outside.
/// A frame is computed when it is requested, on all threads, so that one is in memory at a time;
/// `field` must bear being called by several threads at once.
///
/// Fails for fewer than two times, times that are not finite or do not increase, a size of zero or
/// of more than 2^31 - 1 points along an axis, and a voxel size that is not positive; the source
/// fails for a value that is not finite.
Result<std::unique_ptr<FrameSource>> fieldFrames(std::vector<double> times,
                                                 const std::array<std::size_t, 3>& size,
                                                 const Lattice& lattice, FieldFunction field);

/// The name of the grid metadata that holds its time: a number, written as double.
inline constexpr const char* kTimeMetadata = "t4d_time";

struct VdbFramesOptions {
  /// Values above this are inside (densities). Without it, values below zero are (level sets).
  std::optional<double> iso = {};
  bool below = false;  ///< with `iso`: values below it are inside, not above
  /// Time between two frames; overrides the times in the metadata. Where no grid has one, it is 1.
  std::optional<double> frameTime = {};
  double startTime = 0;  ///< of the first frame, with `frameTime`
  /// The time of each frame of the files, increasing; overrides all of these. Empty for none.
  std::vector<double> times = {};
  /// What is used: points of index space, whose numbers may be negative, and frames counted from 0.
  /// Positions and times stay what they are without it.
  std::optional<Region> region = {};
  std::string grid = {};  ///< use only grids with this name; "" for all
  /// The velocity of each frame, in length units per time unit: a vec3s grid, staggered or not, or
  /// three float grids with .x, _x or x after this name; "" for none. There are then
  /// `substeps` - 1 more frames between every two (advected_frames.h).
  std::string velocity = {};
  std::uint32_t substeps = 1;
  /// Frames with at least this many bytes of values keep them in a temporary file.
  std::size_t largeFrame = kLargeFrame;
};

/// Frames from .vdb files: either several files of one grid each, in the order given, where those
/// of a folder are in natural order of their names, frame2 before frame10; or one file whose grids
/// are the frames, in natural order of their names, and in file order if these are equal.
///
/// Inside are values below zero of float and double grids, or above `iso`, or below it; true values
/// of bool grids, active or not; active points of mask grids. A grid is read again when its frame
/// is requested; the frame uses its values without copying, or has them in a temporary file if it
/// is large.
///
/// These are errors that name the file and the grid: a file that is not VDB, or is truncated or
/// damaged as far as that can be detected (.vdb has no checksums); other types of grid; frames with
/// values mixed with frames without; a fog volume without `iso`, and `iso` for bool and mask grids;
/// transforms that are not a uniform scale with a translation, or take
/// a voxel elsewhere than the first frame's by more than rounding (kSamePlace); a
/// background that is inside; values that are not finite; a frame without a time where another has
/// one; times that do not increase; fewer than two frames. If no frame has a point inside,
/// requesting the last frame is an error.
/// Otherwise frames without inside points are allowed anywhere. With `velocity` also: frames
/// without a time; bool and mask grids; a velocity that is missing, of another type, not finite, or
/// on a lattice with another transform than a uniform scale with a translation.
Result<std::unique_ptr<FrameSource>> openVdbFrames(std::span<const std::filesystem::path> inputs,
                                                   const VdbFramesOptions& options = {});

class InputBytes;

struct VolumeOptions {
  /// Samples above this are inside. Without it, and without `label`, floats below zero are inside
  /// (level sets), and bools that are true.
  std::optional<double> iso = {};
  bool below = false;  ///< with `iso`: samples below it are inside, not above
  /// Samples of this value are no data and lie outside, like everything beyond the samples. NaN
  /// stands for all samples that are not numbers. Not allowed with `label` or for bools.
  std::optional<double> outside = {};
  /// Samples of exactly this value are inside; their surface lies at the midpoints.
  std::optional<std::int64_t> label = {};
  /// Time between two frames; overrides what the file says.
  std::optional<double> frameTime = {};
  std::optional<double> startTime = {};  ///< of the first frame; overrides what the file says
  /// The time of each frame of the files, increasing; overrides all of these. Empty for none.
  std::vector<double> times = {};
  /// Edge lengths of a voxel, along the axes of the file, and position of the first sample;
  /// they override what the file says.
  std::optional<std::array<double, 3>> spacing = {};
  std::optional<std::array<double, 3>> origin = {};
  std::string axes = {};  ///< what the axes of a .npy array are, as "txyz"; "" for that or "xyz"
  /// What is read: samples along x, y and z, and frames, all counted from 0. Positions and times
  /// stay what they are without it.
  std::optional<Region> region = {};
  /// Whether samples are values, such as velocities, that say nothing of what is inside: numbers of
  /// any type and sign.
  bool valuesAlone = false;
  /// The source of the file `-` (volumes/frame_stream.h); null: standard input, which is read once.
  std::shared_ptr<InputBytes> input = {};
  std::string raw = {};  ///< what a .raw file without a header holds: "raw float32 64 64 64 10"
};

/// Frames of samples and where they are. Where the voxels are cubes along the axes, the lattice of
/// `frames` says so. Otherwise it has voxels of 1 at the origin, and `toSpace` maps its points to
/// space, which may turn the mesh inside out: see model::Transformed.
struct VolumeFrames {
  std::unique_ptr<FrameSource> frames;
  std::optional<model::Affine3x4> toSpace;
  std::array<std::uint64_t, 3> sizes = {};  ///< samples along x, y and z
  bool takenAsDistances = false;            ///< floats, of which those below 0 are inside
  /// What positions are relative to a patient, "RAS" (x to the right, y anterior, z superior) or
  /// "LPS"; "" if the file does not say. NRRD's left-handed spaces are mirrored, which `notice`
  /// says.
  std::string space;
  std::string notice;  ///< "" for nothing
  /// Axes of x, y and z along which nothing says how large a voxel is: it is taken as 1.
  std::string unsized;
  /// The axes of the data in the order in which they are taken, as "txyz", if nothing names them.
  std::string assumedAxes;
  std::string lengthUnit;  ///< "" if the file does not say
  std::string timeUnit;
  std::string name;                 ///< of the data, if it is not that of the file; else ""
  std::vector<std::string> notes;   ///< what was assumed when the data were read
  std::vector<std::string> losses;  ///< what was left out then
};

/// Frames from volumes: one file with an axis of time, or several of a frame each, in the order
/// given, or `-`, a stream of frames (volumes/frame_stream.h). Everything beyond the samples is
/// outside. A frame is read when it is requested, and then is in memory as float, or as double if
/// its samples are wider than that or scaled. A file in which time is not the slowest axis is read
/// at once, into a temporary file of the size of its samples. Without a time between frames they
/// are 1 apart. Files of a frame each may place it differently by rounding (kSamePlace); all are
/// taken to be where the first is.
///
/// These are errors that name the file: what its header says is damaged, contradicts the size of
/// the file, or is beyond what is read (volumes/headers.h); integers with neither `iso` nor
/// `label`; samples that are not finite; a region that is not within the samples; voxels without
/// volume; files of one series that differ; fewer than two frames, or more than kMaxFrames. If no
/// frame has a sample inside, requesting the last frame is an error.
Result<VolumeFrames> openVolumeFrames(std::span<const std::filesystem::path> files,
                                      const VolumeOptions& options = {});

}  // namespace t4d::voxel4d
