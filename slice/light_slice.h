#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "slice/slice.h"

namespace t4d::slice {

/// Which triangles represent the solid at a time between two layers.
enum class SliceDetail : std::uint8_t {
  Exact,  ///< those cut by marching tetrahedra: 13 for each triangle of a swept solid
  Light,  ///< those of the layers, interpolated between their two positions
};

struct LightSlice {
  Slice slice;
  bool light = true;  ///< if false, the slice is exact
  /// A bound on the Hausdorff distance to the exact slice.
  double distance = 0;
  std::string whyExact;  ///< if the slice is exact: why the slab has no prisms
};

/// LightSlice::distance for a slab of prisms with these triangles, at a fraction of its time;
/// largest at a quarter.
double lightDistance(const model::Slab& slab, std::span<const model::Triangle> triangles,
                     double fraction);

/// The solid at any time as the triangles of the layers, with vertices between their two positions:
/// (1 - s) P + s Q at fraction s of a slab from the positions P to Q. It has
/// * the triangles of the input of a sweep, in the same order at all times, so that their
///   attributes carry over;
/// * exactly the volume of the exact slice: the law of prisms of 14 cells (mesh4d/sweep.h);
/// * a known distance from the exact slice, which is zero at layers, halfway between two layers,
///   and in steps that are translations.
///
/// The distance. Let s <= 1/2 (otherwise mirror the step), L(i) = (1 - s) P(i) + s Q(i), and D(ij)
/// = (Q(j) - Q(i)) - (P(j) - P(i)) the change of an edge. The exact slice of the prism of a
/// triangle ijk is a disc of 13 triangles with these corners: L(i); on the edge from P(i) to the
/// mean of the quadrilateral ij, a point that differs from (1 - s) L(i) + s L(j) by s (1/2 - s)
/// D(ij); on the edge from P(i) to the mean of the prism, a point that differs from (1 - 4s/3) L(i)
/// + (2s/3) (L(j) + L(k)) by (2s/3) (1/2 - s) (D(ij) + D(ik)). (Insert the means.) The points of
/// the triangle L(i) L(j) L(k) named here divide it into the same 13 triangles, without overlap, so
/// the exact slice is the light one with every point moved by no more than the largest of these
/// differences. `distance` is that, of all triangles. (In a step that turns by theta, |D| is at
/// most 2 sin(theta / 2) times the edge, and the distance at most a sixth of sin(theta / 2) times
/// the longest edge.)
///
/// Only slabs whose cells are prisms with their means have light slices (prisms.h): not those of
/// weave, of sweeps with PrismSplit::Three, or of files that do not mark means. A slice of any
/// other slab is exact. Safe to use from several threads at once.
class LightSlicer {
 public:
  /// `source` must outlive the slicer.
  explicit LightSlicer(const model::Source& source, WithMotion withMotion = WithMotion::No);
  ~LightSlicer();

  /// Times are interpreted, and fail, as in sliceAtTime. A triangle gets the attributes of the cell
  /// over it at the start of the slab; if other cells of its prism have other values, that is a
  /// loss. Vertex attributes are interpolated as in Slicer. Corner attributes (model::kCornersOf),
  /// which sweeps make from the vertex attributes of their input, become vertex attributes again,
  /// unless corners at one vertex differ.
  Result<LightSlice> at(double time) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace t4d::slice
