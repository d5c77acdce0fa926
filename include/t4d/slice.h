#pragma once

/// Sections of a 4D mesh: the solid at a time, or what any hyperplane cuts out.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::slice {

/// All points p of space-time with normal . p = offset. The normal points to the side called
/// "above".
struct Hyperplane {
  Eigen::Vector4d normal = Eigen::Vector4d::UnitW();
  double offset = 0;

  static Hyperplane atTime(double time) { return {Eigen::Vector4d::UnitW(), time}; }
  /// The hyperplane where the coordinate of an axis (0 to 3 for x, y, z, t) is `value`.
  static Hyperplane across(int axis, double value) { return {Eigen::Vector4d::Unit(axis), value}; }
};

/// normal . point, summed in the order x, y, z, t without fused operations, as SPEC.md, section
/// "Slicing", prescribes, so that all programs agree on which points are on a hyperplane.
inline double along(const Eigen::Vector4d& normal, const model::Point4& point) {
  return normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] + normal[3] * point[3];
}

/// Orthonormal coordinates within a hyperplane: multiply the rows by a point of space-time.
///
/// The axis along which the normal is largest is left out (the last one if several are equal). The
/// other three, in the order x, y, z, t, are made orthonormal to the normal and to each other
/// (Gram-Schmidt). For x = c the result is (y, z, t), for t = c it is (x, y, z).
struct HyperplaneBasis {
  Eigen::Matrix<double, 3, 4> axes;
  /// Whether (axis 1, axis 2, axis 3, normal) is oriented like (x, y, z, t).
  bool rightHanded;
};

/// The hyperplane must satisfy checkHyperplane. The opposite normal gives the same axes.
HyperplaneBasis basisOf(const Hyperplane& hyperplane);

/// Fails if a number is not finite, the normal is zero, or the hyperplane is at infinity because
/// the offset is too large for the normal.
Result<void> checkHyperplane(const Hyperplane& hyperplane);

/// An equal hyperplane whose normal has its largest coordinate in [1, 2). Normal and offset are
/// multiplied by a power of two, which is exact. Unchanged if checkHyperplane refuses it.
Hyperplane scaledHyperplane(const Hyperplane& hyperplane);

/// The motion of the surface of a slice at a time, in length units per time unit.
struct SurfaceMotion {
  /// The speed of each triangle along its normal, positive outward. A cell with the outward normal
  /// (n, n_t) in space-time moves with -n_t / |n|.
  std::vector<double> speeds;
  /// The velocity of each vertex, if the slab shows how points move, that is, if it consists of the
  /// prisms of a swept solid: along the segment between the two positions of the vertex. Otherwise
  /// empty.
  std::vector<model::Point3> velocities;
};

/// The section of a 4D mesh by a hyperplane: a closed triangle mesh facing outward, in the
/// coordinates of basisOf(hyperplane).
struct Slice {
  model::TriangleMesh mesh;
  std::uint64_t slabsRead = 0;
  /// Slabs that were not read, because their times or bounds are on one side of the hyperplane.
  std::uint64_t slabsSkipped = 0;
  /// Blocks of 65,536 cells that were read. If the source offers blocks, those that the hyperplane
  /// misses are not read.
  std::uint64_t blocksRead = 0;
  /// Attributes that could not be transferred, one sentence each.
  std::vector<std::string> losses;
  /// The motion of the surface, if the slicer was asked for it (WithMotion).
  std::optional<SurfaceMotion> motion;
};

/// Whether a slicer also finds the motion of its slices, for addVelocity (velocity.h).
enum class WithMotion : std::uint8_t { No, Yes };

/// Whether a vertex exactly on the hyperplane counts as below or above it.
enum class OnHyperplane : std::uint8_t { Below, Above };

/// Marching tetrahedra over slabs in time order.
///
/// A cut point is identified by its edge; if it coincides with a vertex, it is that vertex.
/// Triangles that lose a corner this way are dropped. As a result, the section at a layer is
/// exactly the layer's triangles, without slivers, and every section is closed.
///
/// A triangle gets the cell attributes of the cell it was cut from. Vertex attributes are
/// interpolated along the edge if they are floating-point numbers; otherwise they are those of the
/// vertex below the hyperplane.
///
/// put() fails if checkHyperplane does, or checkConnectivity or checkSlab for the slab; the
/// connectivity is checked once for all consecutive slabs that share it.
class Slicer : public model::Sink {
 public:
  explicit Slicer(const Hyperplane& hyperplane, OnHyperplane rule = OnHyperplane::Below);
  ~Slicer() override;

  Result<void> put(const model::Slab& slab) override;
  Slice finish();

 private:
  friend class TimeSlicer;
  friend Result<Slice> slice(const model::Source&, const Hyperplane&, const model::Progress&);
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Slices a mesh at any number of times. The cut of a slab depends only on its connectivity and on
/// which vertices are after the time. It is kept for the next slice, in which both are often the
/// same, for example in all steps of a swept solid. Safe to use from several threads at once.
class TimeSlicer {
 public:
  /// `source` must outlive the slicer.
  explicit TimeSlicer(const model::Source& source, WithMotion withMotion = WithMotion::No);
  ~TimeSlicer();

  /// The result of sliceAtTime.
  Result<Slice> at(double time) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The solid at `time`: the limit from later times or, at the last time of the mesh, from earlier
/// ones. A time that equals that of a layer up to rounding (model::timeWithin) counts as the
/// layer's time. Reads one slab. Fails if `time` is outside the mesh (the error gives the range),
/// and if the mesh has no slabs.
Result<Slice> sliceAtTime(const model::Source& source, double time);

/// The section by any hyperplane. Skips slabs whose bounds are known without reading and do not
/// meet the hyperplane. Each thread cuts one slab at a time. For a hyperplane of constant time,
/// with the normal (0, 0, 0, w) of either sign, this is sliceAtTime. Fails if checkHyperplane, the
/// Slicer or the source does.
Result<Slice> slice(const model::Source& source, const Hyperplane& hyperplane,
                    const model::Progress& progress = {});

/// The triangles that represent the solid at a time between two layers.
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

/// The solid at each of `times`, which may be in any order. Result i is that of sliceAtTime for
/// times[i], so a time outside the mesh is an error in that result only. Reads each slab at most
/// once, and only slabs that contain one of the times. One slab is in memory besides the slices.
std::vector<Result<Slice>> sliceAtTimes(const model::Source& source, std::span<const double> times,
                                        const model::Progress& progress = {},
                                        WithMotion withMotion = WithMotion::No);

}  // namespace t4d::slice
