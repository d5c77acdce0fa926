#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "t4d/slice/slice.h"

namespace t4d::slice {

/// Which triangles stand for the solid at a time between two layers.
enum class SliceDetail : std::uint8_t {
  Exact,  ///< those that marching tetrahedra cut: 13 for each triangle of a swept solid
  Light,  ///< those of the layers, between their two positions
};

struct LightSlice {
  Slice slice;
  bool light = true;  ///< if not, the slice is the exact one
  /// No point of the surface is further than this from the exact slice, nor the other way round.
  double distance = 0;
  std::string whyExact;  ///< if it is: what the slab is, that has no prisms
};

/// The distance that LightSlice states, of a slab of prisms with these triangles, at a fraction of
/// its time; largest at a quarter.
double lightDistance(const model::Slab& slab, std::span<const model::Triangle> triangles,
                     double fraction);

/// The solid at any time as the triangles of the layers, with vertices between their two places:
/// (1 - s) P + s Q at fraction s of a slab from the positions P to Q. It has
/// * the triangles of the input of a sweep, in the same order at all times, so that what is known
///   of them carries over;
/// * exactly the volume of the exact slice: the law of prisms of 14 cells (mesh4d/sweep.h);
/// * a distance from the exact slice that is known, and zero at layers, half way between two, and
///   in steps that are translations.
///
/// The distance. Let s <= 1/2 (otherwise mirror the step), L(i) = (1 - s) P(i) + s Q(i), and
/// D(ij) = (Q(j) - Q(i)) - (P(j) - P(i)) the change of an edge. What the exact slice has of the
/// prism of a triangle ijk is a disc of 13 triangles with these corners: L(i); on the edge from
/// P(i) to the mean of the quadrilateral ij, a point that differs from (1 - s) L(i) + s L(j) by s
/// (1/2 - s) D(ij); on the edge from P(i) to the mean of the prism, a point that differs from (1 -
/// 4s/3) L(i) + (2s/3) (L(j) + L(k)) by (2s/3) (1/2 - s) (D(ij) + D(ik)). (Insert the means.) The
/// points of the triangle L(i) L(j) L(k) named here divide it into the same 13 triangles, without
/// overlap, so the exact slice is the light one with every point moved by no more than the largest
/// of these differences. `distance` is that, of all triangles. (In a step that turns by theta, |D|
/// is at most 2 sin(theta / 2) times the edge, and the distance at most a sixth of sin(theta / 2)
/// times the longest edge.)
///
/// Only slabs whose cells are prisms with their means have such triangles (prisms.h): not those of
/// weave, of sweeps with PrismSplit::Three, or of files that do not say which vertices are means. A
/// slice of another slab is the exact one. Safe to use from several threads at once.
class LightSlicer {
 public:
  /// `source` must outlive the slicer.
  explicit LightSlicer(const model::Source& source, WithMotion withMotion = WithMotion::No);
  ~LightSlicer();

  /// Times are interpreted, and fail, as in sliceAtTime. Attributes: a triangle has the values of
  /// the cell over it at the start of the slab, and if other cells of its prism have others, that
  /// is a loss. Those of vertices are interpolated as in Slicer. An attribute of corners
  /// (model::kCornersOf), as sweeps make of those of their input, becomes one of vertices again,
  /// unless corners at one vertex differ.
  Result<LightSlice> at(double time) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace t4d::slice
