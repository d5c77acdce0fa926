#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "model/slab.h"
#include "model/triangle_mesh.h"

/// The silhouette of a 4D mesh: a surface in space that tells how often each place is visited.
///
/// A cell is an exit if its outward normal has n_t > 0, and an entry if n_t < 0. A vertical line,
/// one place at all times, enters and leaves the solid in turn, so the number of times k(p) that a
/// place p is visited is the number of exits that cover p when they are projected along t. The
/// boundary of all projected exits, the triangles between an exit and a cell that is none, is
/// therefore a closed surface in space whose winding number at p is k(p). Cells with n_t = 0
/// project to nothing and count as no exits.
///
///        t    exits
///        ^   _________            The silhouette of a disc that moves along a line is the
///        |  /        /\           triangles (here points) where exits and entries meet: each
///        | /        / entries     encloses what has been visited.
///        |/________/
///        o----------o----> x      silhouette
namespace t4d::measure {

struct Silhouette {
  /// Closed and oriented: counter-clockwise seen from the side that is visited less often. It may
  /// cross itself, and more than two triangles may have an edge.
  model::TriangleMesh surface;
  /// The integral of k over space, the sum of the projected volumes of all exits.
  double visitsVolume = 0;
  /// The hypervolume: the integral over space of the time that each point is covered.
  double hypervolume = 0;
  /// The hypervolume computed as the flux of (x, y, z, 0) / 3 through all cells, as a check. Not
  /// meaningful for a slab alone.
  double hypervolumeByFlux = 0;
  std::uint64_t exits = 0;
  std::uint64_t entries = 0;
  double solidExtent = 0;  ///< the largest extent of the first slab, in a sweep the solid's
  /// The smallest extent, along the axes or along its own principal axes, that a component of the
  /// first slab has; 0 if none has one.
  double partExtent = 0;
  /// The volume of the solid at its first time or at its last one, the larger one; 0 for a mesh
  /// without caps. The envelope has no less.
  double solidVolume = 0;
};

class SilhouetteTopology;

/// Makes the silhouette of one 4D mesh slab by slab. Keeps one layer and the silhouette so far in
/// memory.
///
/// Which cells are exits is decided by exact signs. In a slab without thickness that has only a
/// lower layer, an end cap, all cells count as exits, with the sign of their projection, and in a
/// start cap as entries: so caps whose cells overlap (cones) visit nothing twice.
///
/// `put` fails for a slab that is invalid, `finish` if the mesh is not closed.
class SilhouetteBuilder : public model::Sink {
 public:
  SilhouetteBuilder();
  ~SilhouetteBuilder() override;

  Result<void> put(const model::Slab& slab) override;

  /// Call it once, after the last slab.
  Result<Silhouette> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The silhouette of one mesh: its slabs put into a SilhouetteBuilder.
Result<Silhouette> silhouetteOf(const model::Source& source, const model::Progress& progress = {});

/// Silhouettes of slabs, each by itself as a closed solid in space-time, as if the solid appeared
/// with the slab's lower layer and disappeared with its upper one: the winding number is positive
/// exactly where the solid has been during the slab. What depends on the connectivity alone is
/// computed once for consecutive slabs that share it.
class SlabSilhouettes {
 public:
  SlabSilhouettes();
  ~SlabSilhouettes();

  /// Empty for a slab without thickness. Fails for an invalid slab, and one that is not closed but
  /// for its layers.
  Result<Silhouette> of(const model::Slab& slab);

 private:
  std::shared_ptr<const SilhouetteTopology> topology_;
};

}  // namespace t4d::measure
