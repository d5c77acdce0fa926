#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "t4d/error.h"
#include "t4d/frames.h"
#include "t4d/surface.h"

namespace t4d::mill {

/// A solid on a lattice from which others are taken away: a field that is negative inside, near its
/// surface the distance from it along lattice lines, as float32. Lattice points are multiples of
/// the voxel size.
///
/// Where a closed surface crosses the edges of the lattice is exact (measure::VisitLattice), and an
/// end of such an edge gets its distance from the plane of the triangle there, the smallest of all
/// edges: a plane is where the field, linear along edges, is zero, but for rounding to float32.
/// What is removed from what is left is max(field, -tool), so no value ever falls.
///
/// Copies share the blocks that do not differ.
class StockField {
 public:
  /// A field of the right size without values: what `of` begins with, and fails with.
  static Result<StockField> sized(const model::TriangleMesh& solid, double voxelSize,
                                  double memory);

  /// `solid` is closed; inside is where its winding number is 1 or more. Fails for a voxel size at
  /// which more than `memory` bytes are needed, with one that fits.
  static Result<StockField> of(const model::TriangleMesh& solid, double voxelSize, double memory);

  /// Fails for a solid that is too large to be removed with `memory` bytes.
  static Result<void> checkSize(const model::TriangleMesh& solid, double voxelSize, double memory);

  /// Whether no lattice point is inside.
  bool empty() const;

  /// Whether a solid with these bounds can meet this one.
  bool mayMeet(const model::Bounds3& bounds) const;

  /// Something that was found at a place.
  struct Place {
    model::Point3 point = model::Point3::Zero();
    std::uint64_t points = 0;  ///< number of lattice points; 0: nothing found
    bool changes = false;      ///< whether a value has changed, which moves the surface
  };

  /// Removes what a closed surface has a winding number of 1 or more in. Returns the lattice points
  /// that have changed from inside to outside, and the one of them that was deepest inside.
  Result<Place> remove(const model::TriangleMesh& surface);

  /// The lattice points inside of both, and the one that is deepest in this one.
  Result<Place> meet(const model::TriangleMesh& surface) const;

  /// The field as a frame, which keeps what it needs of this in memory.
  voxel4d::Frame frame(double time) const;
  voxel4d::Lattice lattice() const { return {voxelSize_, model::Point3::Zero()}; }

  /// Runs of points inside along z, by x and y: for what looks at all points.
  struct Run {
    std::int32_t begin = 0;
    std::int32_t end = 0;  ///< one more than the last
  };
  /// The runs of the line (x, y), counted from firstPoint().
  void runsOf(std::int32_t x, std::int32_t y, std::vector<Run>& runs) const;
  /// The number of points along each axis.
  std::array<std::int32_t, 3> pointCounts() const;

 private:
  struct BlockData {
    std::array<float, 512> values{};
    voxel4d::BlockMask inside{};
  };
  enum class Uniform : std::uint8_t { Outside, Inside };

  class Sampled;

  std::size_t indexOf(const std::array<std::int32_t, 3>& block) const;
  float band() const { return static_cast<float>(voxelSize_); }
  bool gatherTiles(const std::array<std::int32_t, 3>& at, std::int32_t size,
                   std::vector<voxel4d::InsideTile>& tiles) const;

  double voxelSize_ = 1;
  std::array<std::int32_t, 3> first_{};   // block
  std::array<std::int32_t, 3> counts_{};  // of blocks
  // Of each block: its values, or what it is as a whole.
  std::vector<std::shared_ptr<const BlockData>> blocks_;
  std::vector<Uniform> uniform_;
};

}  // namespace t4d::mill
