#pragma once

#include <Eigen/Core>

#include "t4d/mesh.h"

namespace t4d::voxel4d {

/// Frames are on one lattice if none of their samples is farther than this from that of the first
/// frame, in voxels. Files store positions as float32 or with six digits, so those of one series
/// differ by rounding: 5e-5 voxels for 512 of them. A thousandth is how close to a lattice point a
/// vertex can be.
inline constexpr double kSamePlace = 1e-3;

/// How far two maps of index space to space take the same point apart, at most, for points from
/// `low` to `high`; in edges of the smallest voxel of `a`. The difference of two such maps is
/// largest at a corner of the box.
double voxelsApart(const model::Affine3x4& a, const model::Affine3x4& b, const Eigen::Vector3d& low,
                   const Eigen::Vector3d& high);

}  // namespace t4d::voxel4d
