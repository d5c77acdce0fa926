#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "measure/silhouette.h"
#include "model/error.h"

namespace t4d::edit {

struct EnvelopeOptions {
  /// The spacing of the lattice on which visits are counted; 0 for defaultVoxelSize.
  double voxelSize = 0;
  /// Make an envelope that contains every place no farther than this from where the solid has been,
  /// in length units: with the bound of chords (measure/chord_bound.h), every place of the true
  /// motion. Not with `exact`.
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
  /// Nothing in a build without CGAL, which does not look for them.
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
/// of coordinates added to the reach. What is thin is in it, too.
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

/// How far places computed from a surface are off by rounding, at most.
double roundingOfComputing(const model::TriangleMesh& surface);

/// Adds one silhouette to another: visits of both.
void add(measure::Silhouette& to, const measure::Silhouette& other);

}  // namespace t4d::edit
