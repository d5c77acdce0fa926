#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "t4d/check.h"
#include "t4d/mesh.h"

/// Tracks of a mesh from those of its parts, each found alone. A part begins in the slab before its
/// own, of which it takes the surfaces at the end as they are: which face outward, which are within
/// which, and their Euler numbers. So it works on the layer there, and no event is lost or found
/// twice.
namespace t4d::measure {

/// A surface of the slice just before the layer between two parts.
struct SurfaceAtSeam {
  std::uint32_t track = 0;
  /// For a cavity that appeared within its solid in this part: the event.
  std::optional<std::size_t> appears = {};
  /// For a surface since before the part that has not taken part in an event: its number in
  /// `first`.
  std::optional<std::uint32_t> atFirst = {};
  double largestVolume = 0;  ///< in a sample of this part
};

/// A cavity of before a part that is filled in it.
struct CarriedCavity {
  std::uint32_t atFirst = 0;  ///< its number in `first`
  std::size_t vanishes = 0;   ///< event
  double largestVolume = 0;   ///< in a sample of this part
};

/// Tracks in some consecutive slabs of a mesh.
struct PartOfTracks {
  /// The tracks. Those that exist before the part come first and begin with it; others may end with
  /// it.
  Tracks tracks;
  /// Surfaces just before the part and just before its end, in an order that depends on the slab
  /// there alone.
  std::vector<SurfaceAtSeam> first = {};
  std::vector<SurfaceAtSeam> last = {};
  std::vector<CarriedCavity> carriedCavities = {};
};

/// The tracks in some slabs of a closed mesh, and in those without duration just before them,
/// instead of those at their end. Nothing is pruned, and samples have no speeds. Fails as tracksOf
/// does.
Result<PartOfTracks> tracksOfPart(const model::Source& source, const TrackOptions& options,
                                  model::PartRange slabs, const model::Progress& progress = {});

/// The tracks of the whole mesh, as tracksOf finds them, from those of consecutive parts of all of
/// it. Fails if they do not continue each other, and if in a mesh that intersects itself it is
/// another solid that a surface seems to bound before the layer between two parts than after it.
Result<Tracks> joinedTracks(std::vector<PartOfTracks> parts, const TrackOptions& options);

}  // namespace t4d::measure
