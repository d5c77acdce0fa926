#pragma once

#include <cstdint>
#include <vector>

#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::mesh4d {

/// The layers of a rigid motion: the start, and the end of every step. Steps divide a segment
/// evenly in time, and poses are in closed form, so errors do not accumulate.
class MotionKeys : public model::VertexKeys {
 public:
  /// `steps` has the number of steps of each segment. The mesh and the motion must outlive the
  /// keys.
  MotionKeys(const model::TriangleMesh& mesh, const model::Motion& motion,
             const std::vector<std::uint64_t>& steps);

  std::uint64_t count() const override { return stepsUpTo_.back() + 1; }
  double time(std::uint64_t key) const override;
  std::optional<model::Affine3x4> pose(std::uint64_t key) const override;
  /// Fails if the step before the key is too short to represent.
  Result<void> positions(std::uint64_t key, std::span<model::Point3> into) const override;

 private:
  /// A key as the end of a step; the start of the motion is step 0 of its first segment.
  struct Place {
    std::size_t segment;
    std::uint64_t step;
    std::uint64_t steps;  // of the segment
  };
  Place placeOf(std::uint64_t key) const;

  const model::TriangleMesh& mesh_;
  const model::Motion& motion_;
  std::vector<std::uint64_t> stepsUpTo_;  // number of steps up to the end of each segment
};

}  // namespace t4d::mesh4d
