#pragma once

#include <array>
#include <vector>

#include "t4d/model/slab.h"

/// Small closed 4D meshes whose hypervolume and slices have closed forms. Positions take no
/// function but +, -, *, / of decimal numbers, so that they are the same bits everywhere.
namespace t4d::conformance {

/// The boundary of the 4-simplex with the corners `origin` and `origin` + `size` along each axis:
/// one slab with empty layers. Encloses size^4 / 24.
std::vector<model::Slab> simplex(double size = 1, const model::Point4& origin = {0, 0, 0, 0});

/// The boundary of the cross-polytope with the corners +-1 on each axis, as two slabs that share a
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
/// Unit cubes with these lowest corners, each in six tetrahedra. Their volume is their number.
Solid cubes(const std::vector<std::array<int, 3>>& corners);

/// Where the vertices of a solid are at a time.
struct Pose {
  double time = 0;
  std::vector<model::Point3> vertices;
};

enum class Prism : std::uint8_t {
  Three,     ///< three cells a step of a triangle, without further vertices
  Fourteen,  ///< fourteen, with a mean in each quadrilateral and one in the middle
};

/// How the moving solid is cut into slabs.
struct SweepOptions {
  Prism prism = Prism::Three;
  bool capSlabs = true;  ///< the ends are slabs of their own; else part of the first and last step
  /// Cap slabs join the solid's surface to a mean of its vertices, instead of taking its cells.
  bool cones = false;
};

/// The boundary of a solid that moves through poses, straight from one to the next. Where the
/// motion is a translation or a scaling about a point, hypervolume and slices are exactly those of
/// the moving solid, with either prism.
std::vector<model::Slab> sweep(const Solid& solid, const std::vector<Pose>& poses,
                               const SweepOptions& options = {});

/// The boundary of a solid that is made of unit cubes with lowest corners `frames[k]` from time k
/// to k + 1: cubic 3-faces, six cells each. Cubes of a frame, and of one and the next, must not
/// meet in edges or corners alone. A slice between k and k + 1 encloses as much as there are cubes.
std::vector<model::Slab> cubesInTime(const std::vector<std::vector<std::array<int, 3>>>& frames);

/// `solid` scaled and then moved.
Pose pose(const Solid& solid, double time, const model::Point3& offset, double scale = 1);
/// `solid` turned about the z axis by k times the angle whose cosine is 0.6, and moved by `offset`.
Pose turned(const Solid& solid, double time, int k, const model::Point3& offset);

}  // namespace t4d::conformance
