#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/slab.h"
#include "model/triangle_mesh.h"
#include "slice/hyperplane.h"

namespace t4d::slice {

/// How the surface of a slice at a time moves, in length units per time unit.
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

}  // namespace t4d::slice
