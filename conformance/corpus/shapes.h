#pragma once

#include <array>
#include <functional>
#include <vector>

#include "t4d/mesh.h"

/// Small closed 4D meshes whose hypervolume and slices have closed forms. Positions are computed
/// with +, -, *, / of decimal numbers only, so they have the same bits on every platform.
namespace t4d::conformance {

/// The boundary of the 4-simplex with the corners `origin` and `origin` + `size` along each axis:
/// one slab with empty layers. Encloses size^4 / 24.
std::vector<model::Slab> simplex(double size = 1, const model::Point4& origin = {0, 0, 0, 0});

/// 13,108 simplices at the same position, without shared vertices: 65,540 cells in one slab, four
/// more than fit into one block.
model::Slab manySimplices();

/// 8,200 cross-polytopes at the same position, without shared vertices, in two slabs of 65,600
/// cells that share a layer. Encloses 8,200 times what crossPolytope does.
std::vector<model::Slab> manyCrosses();

/// The boundary of the cross-polytope with corners at +-1 on each axis, as two slabs that share a
/// layer of 6 vertices at t = 0. Encloses 2/3; a slice at t encloses 4/3 (1 - |t|)^3.
std::vector<model::Slab> crossPolytope();

/// A solid of tetrahedra, each with det[b-a, c-a, d-a] > 0.
struct Solid {
  std::vector<model::Point3> vertices;
  std::vector<model::Cell> cells;
};

/// The corner of the unit cube: the origin and the three unit points. Volume 1/6.
Solid cornerTetrahedron();
/// A cube from the origin to (side, side, side) in six tetrahedra. Volume side^3.
Solid cube(double side = 1);
/// Unit cubes with these lowest corners, each in six tetrahedra. The volume is the number of cubes.
Solid cubes(const std::vector<std::array<int, 3>>& corners);

/// The positions of a solid's vertices at one time.
struct Pose {
  double time = 0;
  std::vector<model::Point3> vertices;
};

enum class Prism : std::uint8_t {
  Three,     ///< three cells per step of a triangle, no extra vertices
  Fourteen,  ///< fourteen, with a mean in each quadrilateral and one in the middle
};

/// The division of the boundary of a moving solid into slabs.
struct SweepOptions {
  Prism prism = Prism::Three;
  bool capSlabs = true;  ///< the ends are separate slabs, not part of the first and last step
  /// Cap slabs join the solid's surface to a mean of its vertices, instead of using its cells.
  bool cones = false;
};

/// The boundary of a solid that moves through poses along straight lines. For a translation or a
/// scaling about a point, hypervolume and slices are exactly those of the moving solid, with either
/// prism.
std::vector<model::Slab> sweep(const Solid& solid, const std::vector<Pose>& poses,
                               const SweepOptions& options = {});

/// The boundary of a solid made of unit cubes with lowest corners `frames[k]` from time k to k + 1:
/// cubic 3-faces, six cells each. Cubes of a frame, and of consecutive frames, must not meet only
/// in edges or corners. A slice between k and k + 1 has the number of cubes as its volume.
std::vector<model::Slab> cubesInTime(const std::vector<std::vector<std::array<int, 3>>>& frames);

/// 1,170 tetrahedra apart that rise from 0 to 1, in three slabs: caps, and a step with fourteen
/// cells per triangle and five simplices besides. Encloses 195 + 5/24. Of the 65,545 cells of the
/// step the last 9 are in a block of their own. They need vertices of each part of the slab, some
/// only as sources of means, which lie beyond the bounds of the cells.
std::vector<model::Slab> manyPrisms();

/// A copy of `slabs` in which the upper layer of slab k, if it has one, is that of the first slab
/// moved by `poseOf(k)`, with Slab::upperPose set. With `float32` both are rounded.
std::vector<model::Slab> withPoses(std::vector<model::Slab> slabs,
                                   const std::function<model::Affine3x4(std::size_t k)>& poseOf,
                                   bool float32 = false);

/// The map that moves by `offset`.
model::Affine3x4 movedBy(const model::Point3& offset);

/// The pose of `solid` scaled and then moved.
Pose pose(const Solid& solid, double time, const model::Point3& offset, double scale = 1);
/// The pose of `solid` rotated about the z axis by k times the angle whose cosine is 0.6, and moved
/// by `offset`.
Pose turned(const Solid& solid, double time, int k, const model::Point3& offset);

}  // namespace t4d::conformance
