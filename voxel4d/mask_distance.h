#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "voxel4d/frame_layer.h"

namespace t4d::voxel4d {

/// How far lattice points of a frame are from its faces, those between a voxel inside and one
/// outside, where a voxel is the box about its lattice point: what a frame without values has
/// instead of a field. Euclidean, with the edge lengths of the voxels counted; found by one axis
/// after the other (Felzenszwalb and Huttenlocher, Distance transforms of sampled functions, 2012),
/// about one block at a time.
class FaceMetric {
 public:
  /// No face that is more voxels away than this along an axis is looked for.
  static constexpr std::int32_t kReach = 24;
  /// What is farther from all faces counts as this far from one, in shortest edges. So a point that
  /// goes from one label to another leaves the one before it joins the other: what is not of the
  /// one includes the other, and is nearer.
  static constexpr float kMost = static_cast<float>(kReach) + 0.5F;

  /// The voxels have these edge lengths, in any unit.
  explicit FaceMetric(const std::array<double, 3>& edges);

 private:
  friend class FaceDistance;
  /// Along each axis, by the number of voxels from a point to another: the square of the distance
  /// from the point to the voxel. The unit is the shortest edge.
  std::array<std::array<float, kReach + 1>, 3> squares_{};
};

/// The distances of the points of one block.
class FaceDistance {
 public:
  /// The frame and the metric must outlive this object.
  FaceDistance(const FrameLayer& frame, const FaceMetric& metric, const Coord& block)
      : frame_(frame), metric_(metric), block_(block), own_(frame.view(block)) {}

  /// The distance of a point, by its index in the order of BlockMask, from the nearest face, in
  /// shortest edges, but at most kMost: negative inside.
  double at(unsigned index);

 private:
  using Squares = std::array<float, 512>;  // of the distances of the points of the block
  template <std::int32_t kBlocks>
  class Neighbourhood;

  const FrameLayer& frame_;
  const FaceMetric& metric_;
  Coord block_;
  BlockView own_;
  // Distances from voxels outside and inside: first those of the next blocks, which suffice for
  // most points.
  std::array<std::unique_ptr<Squares>, 2> near_;
  std::array<std::unique_ptr<Squares>, 2> far_;
};

}  // namespace t4d::voxel4d
