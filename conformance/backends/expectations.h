#pragma once

#include <cstdint>
#include <vector>

#include "conformance/backends/case.h"
#include "conformance/oracle.h"

/// The closed form of a case for each way of making its 4D mesh, and the tolerances, all of which
/// are derived here.
namespace t4d::conformance {

/// A mesh swept in steps (mesh4d). For any closed mesh, any axis and any translation, the slice at
/// fraction s of a step that turns by theta has exactly the volume
/// V0 (1 - 2 s (1 - s) (1 - cos theta)), so a step of duration dt encloses
/// V0 dt (2 + cos theta) / 3. Tolerances cover rounding only. With `cones` the ends are closed by
/// cones, not by TetGen.
Result<Expectation> sweptExpectation(const Case& given, bool cones);

/// Voxel size and number of frames, refined together.
struct Resolution {
  double voxelSize = 0;     ///< 0 if the backend has no voxels
  std::uint64_t steps = 0;  ///< intervals between frames; 0 if the backend has no voxels
};

/// The voxel sizes of the case, each with enough frames that nothing moves by more than a voxel
/// between two of them, or by VoxelPlan::maskMotion voxels.
std::vector<Resolution> voxelResolutions(const Case& given);

/// A mesh woven from voxels (voxel4d): the true solid, within the error of interpolating the
/// distance linearly in cells of diameter D, D^2 = 3 h^2 + (motion between two frames)^2:
///
/// * Across an edge of the solid the distance has a kink. There a linear interpolation is off by at
///   most |difference of normals| D / 4, on a strip at most 2 D wide, and by half of that on
///   average: a volume of bending D^2 / 4. On a smooth surface, half of this volume bounds the
///   interpolation error in space; acceleration adds less than the other half.
/// * Faces that turn by an angle a between two frames make the distance bilinear in space and time:
///   the error is at most a h sqrt(3) / 4, and along the arc a h / 8.
/// * Vertices are kept a thousandth of a voxel off the lattice (voxel4d::kOffLattice), which moves
///   a face on the lattice by as much.
/// * The surface of a mask, and so the distance from it, is off by at most half a voxel's diagonal.
///
/// Each vertex of a slice shares its cell with a point inside and one outside, so its distance from
/// the surface is at most the diagonal of a voxel plus the motion between two frames.
Expectation voxelExpectation(const Case& given, const Resolution& resolution);

/// The paper's mask frames; requires `voxels.mask`.
Expectation maskExpectation(const Case& given);

/// The true solid of a mesh case, within a relative tolerance, for a backend whose method is
/// unknown. It may close the ends by cones.
Expectation solidExpectation(const Case& given, double relativeTolerance);

}  // namespace t4d::conformance
