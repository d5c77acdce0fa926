#pragma once

/// The envelope of a moving solid: all points where it has been.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

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
  /// The hypervolume computed as the flux of (x, y, z, 0) / 3 through all cells, as a check. It is
  /// not meaningful for a slab alone.
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

namespace t4d::edit {

struct EnvelopeOptions {
  /// The spacing of the lattice on which visits are counted; 0 for defaultVoxelSize.
  double voxelSize = 0;
  /// Make an envelope that contains every place no farther than this from where the solid has been,
  /// in length units: with the bound of chords (measure/chord_bound.h), every place of the true
  /// motion. It excludes `exact`.
  std::optional<double> reach = {};
  /// The most memory to use.
  double maxBytes = 4e9;
  /// Cut the triangles of the silhouette where they meet, instead of counting on a lattice.
  bool exact = false;
  /// The time that a default voxel size is made for, in seconds of one core
  /// (VisitLattice::estimatedSeconds).
  double defaultSeconds = 20;
  /// Round vertices to float32 relative to this point, as some formats will.
  std::optional<model::Point3> singlePrecisionAbout = {};
};

/// The boundary of where a solid has been.
struct Envelope {
  model::TriangleMesh mesh;  ///< closed, oriented, manifold; empty if nothing has a volume
  double voxelSize = 0;      ///< 0 if it is exact
  /// Every place that is farther than this from the true boundary is on its true side. With a
  /// reach, no place within is farther than this from where the solid has been.
  double errorBound = 0;
  double volume = 0;
  std::uint64_t components = 0;  ///< connected parts of the solid
  std::uint64_t cavities = 0;
  double genus = 0;  ///< sum of those of all connected surfaces
  /// The number of self-intersections; nothing in a build without CGAL, which does not look for
  /// them.
  std::optional<std::uint64_t> selfIntersections = {};
  std::vector<std::string> losses = {};  ///< what is missing, or may be, each a sentence
};

/// A 64th of the solid's extent at its first time, but no less than a 512th of the envelope's;
/// at most a quarter of the smallest extent of a component of the solid, but no less than a 4096th
/// of the envelope's. With a reach, which thin components are within in any case, at least an
/// eighth of the reach instead, and what float32 can tell apart. Larger if that takes more than
/// `maxBytes` or `defaultSeconds`. Rounded to two digits. 0 for a silhouette without extent.
double defaultVoxelSize(const measure::Silhouette& silhouette, const EnvelopeOptions& options);

/// The envelope of a 4D mesh, or of several whose silhouettes have been put together (`add`): where
/// the winding number of the silhouette is 1 or more.
///
/// On a lattice (visit_lattice.h, lattice_surface.h) it has every place right that is farther than
/// sqrt(3) voxels from the boundary; what is thinner may be missing. `losses` says so where a
/// component of the solid is thin at its first time, where the envelope has less volume than the
/// solid, and where it has more components than the silhouette. Smooth boundaries converge
/// with the second order, and edges stay sharp. Where vertices that are rounded make triangles
/// cross, the cubes there are made plain.
///
/// With a reach it is an OffsetSurface of the lattice (measure/offset_surface.h), with the rounding
/// of coordinates added to the reach. It includes thin places.
///
/// The exact one is the outer surface (outer_surface.h), with its vertices rounded and what touches
/// itself moved apart.
///
/// Fails for a chosen voxel size out of range (model/voxel_size.h); for a voxel size that needs
/// more memory than the options allow, with one that fits; for one that finds nothing of a solid
/// that has a volume; if the coordinates are too coarse for it; and the exact one where too many
/// triangles meet, and in a build without CGAL.
Result<Envelope> envelopeOf(const measure::Silhouette& silhouette, const EnvelopeOptions& options,
                            const model::Progress& progress = {});

/// Sets the volume, the genus and the numbers of components and cavities to those of the mesh.
void measureParts(Envelope& envelope);

/// The largest rounding error of positions that are computed from a surface.
double roundingOfComputing(const model::TriangleMesh& surface);

/// Adds one silhouette to another: visits of both.
void add(measure::Silhouette& to, const measure::Silhouette& other);

}  // namespace t4d::edit
