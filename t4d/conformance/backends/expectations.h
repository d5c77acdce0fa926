#pragma once

#include <cstdint>
#include <vector>

#include "t4d/conformance/backends/case.h"
#include "t4d/conformance/oracle.h"

/// What a 4D mesh of a case must be, for each way of making it: the closed forms and, derived here
/// and nowhere else, how far from them a right mesh may be.
namespace t4d::conformance {

/// A mesh swept in steps (mesh4d). For any closed mesh, any axis and any translation, the slice at
/// fraction s of a step that turns by theta has exactly the volume
/// V0 (1 - 2 s (1 - s) (1 - cos theta)), so a step of duration dt encloses V0 dt (2 + cos theta)
/// / 3. Tolerances are those of rounding. With `cones` the ends are closed by cones, not by TetGen.
Result<Expectation> sweptExpectation(const Case& given, bool cones);

/// Voxels of an edge, and equally many frames a voxel of motion.
struct Resolution {
  double voxelSize = 0;     ///< 0 where a backend knows of none
  std::uint64_t steps = 0;  ///< between frames; 0 likewise
};

/// The voxel sizes of the case, with so many frames that nothing moves by more than a voxel between
/// two of them.
std::vector<Resolution> voxelResolutions(const Case& given);

/// A mesh woven from voxels (voxel4d): the true solid, within the error of interpolating the
/// distance linearly in cells of diameter D, D^2 = 3 h^2 + (motion between two frames)^2:
///
/// * Across an edge of the solid the distance has a kink. A linear interpolation errs by at most
///   |difference of normals| D / 4 there, on a strip of at most 2 D, on average by half: a volume
///   of bending D^2 / 4. Where the surface is smooth, half of that bounds the interpolation in
///   space; the rest is more than acceleration adds.
/// * Faces that turn by a between two frames make the distance bilinear in space and time: it errs
///   by at most a h sqrt(3) / 4, and along the arc by a h / 8.
/// * Vertices are kept a thousandth of a voxel off the lattice (voxel4d::kOffLattice), which moves
/// a
///   face that falls on the lattice by as much.
///
/// And each vertex of a slice shares its cell with a point inside and one outside: the surface is
/// no farther away than the diagonal of a voxel and the motion between two frames.
Expectation voxelExpectation(const Case& given, const Resolution& resolution);

/// The paper's mask frames: the case has `voxels.mask`.
Expectation maskExpectation(const Case& given);

/// The true solid of a mesh case, within a fraction of what is measured: for a backend of which
/// nothing else is known. It may close the ends by cones.
Expectation solidExpectation(const Case& given, double relativeTolerance);

}  // namespace t4d::conformance
