#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "measure/visit_lattice.h"

namespace t4d::measure {

/// The surface between the points of a lattice that are inside and the others: closed, oriented,
/// manifold, and without self-crossings up to the rounding of its vertices.
///
/// In each cube with corners of both kinds, the crossings of its edges are joined by segments on
/// its faces, so that they cut inside corners off, to loops. A cone over each loop, from a point
/// within the cube, is the surface in the cube: a cone over a simple closed curve on the boundary
/// of a convex body does not cross itself. Where a cube has several loops, each cone lies in the
/// convex hull of its loop, and these hulls are separated by planes. The apex is the point that is
/// nearest to the planes of the surface at the crossings (least squares; Ju et al. 2002), so it
/// lies on the edge or corner of the surface if there is one within the cube.
///
/// Where two cubes with an edge of the surface in them meet at a face and the segment between the
/// apexes goes through that face, it replaces the segment on the face (Kobbelt et al. 2001):
///
///       e1           e1           The two cones stay cones, over loops that go through the place
///      /|\          /  \          where the new segment meets the face: nothing crosses.
///     a | b   ->   a----b
///      \|/          \  /
///       e2           e2
///
/// So sharp edges stay sharp but where they pass from cube to cube across an edge or a corner.
class LatticeSurface {
 public:
  /// `visits` must outlive the object.
  explicit LatticeSurface(const VisitLattice& visits);

  /// Triangles are counter-clockwise seen from outside. Vertices are first the crossings of edges
  /// along x, y and z, then apexes.
  const model::TriangleMesh& mesh() const { return mesh_; }

  /// Crossings keep this part of a spacing away from the ends of their edges, and apexes from the
  /// sides of their cubes.
  static constexpr double kMargin = 0x1p-10;

  /// Makes plain again the cubes that have these triangles and the cubes beside them: the apex is
  /// the mean of the loop, and edges are not replaced. Changes the numbers of triangles; false if
  /// all of them were plain.
  bool makePlain(std::span<const std::uint32_t> triangles);

 private:
  struct Cone {
    std::uint64_t cube;
    std::uint32_t first;  // of the loop in loops_
    std::uint8_t size;
    bool alone;  // the only one of its cube
    bool sharp;
    bool plain;
  };

  void addCones();
  void setApexes();
  model::Point3 placeAt(std::uint64_t cube, const model::Point3& fraction) const;
  std::uint32_t coneAcross(const Cone& cone, int face) const;
  bool isReplaced(const Cone& cone, const Cone& other, int face) const;
  void setTriangles();

  const VisitLattice& visits_;
  const SpaceLattice& lattice_;
  std::vector<Cone> cones_;           // in the order of the cubes
  std::vector<std::uint32_t> loops_;  // vertices
  std::vector<std::uint8_t> faces_;   // of each segment: the face of the cube it lies on
  std::uint32_t firstApex_ = 0;
  std::vector<std::uint32_t> coneOf_;  // of each triangle
  model::TriangleMesh mesh_;
};

}  // namespace t4d::measure
