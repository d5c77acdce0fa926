#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "t4d/check.h"
#include "t4d/mesh.h"

/// The components of a solid over time: when each appears, splits, merges and vanishes.
///
/// The slice of a closed mesh at a time is a set of closed surfaces. Between two times at which
/// the mesh has vertices they move and change their shape, but not their number, their Euler
/// numbers or which is within which. So every change has the exact time of vertices of the mesh,
/// which is taken as it is, straight between layers. A change is found by comparing the slice just
/// before a time with the slice just after it; all vertices of one time count together, and the
/// surfaces that the slice at that time connects are one change (SlabReeb).
///
/// A component of the solid is what an outward surface encloses, less the cavities in it, whose
/// surfaces face inward. A track is a component from the time at which it appears, or comes out of
/// a split or a merger, to the time at which it vanishes, splits or merges. It keeps its number
/// while holes and cavities open and close in it. Those that exist at the first time of the mesh
/// begin with it, however they came to be, and those that exist at the last time end with it:
/// neither is an event.
namespace t4d::measure {

enum class TrackEventKind : std::uint8_t {
  Appears,         ///< none before, one or more after
  Vanishes,        ///< one or more before, none after
  Splits,          ///< one before, several after
  Merges,          ///< several before, one after
  Rearranges,      ///< several before, several after
  HoleOpens,       ///< a surface has a handle more: its genus rises by `count`
  HoleCloses,      ///< it falls by `count`
  CavityAppears,   ///< cavities begin within the solid
  CavityVanishes,  ///< they are filled
  CavityOpens,     ///< they are connected to the outside or to a cavity around the solid
  CavityCloses,    ///< they are cut off from it
  CavitiesSplit,   ///< there are `count` more, out of others
  CavitiesMerge,   ///< there are `count` less
};

/// What happens to components at one time and place.
struct TrackEvent {
  double time = 0;
  TrackEventKind kind = TrackEventKind::Appears;
  /// The mean of the vertices of the mesh where the topology changes.
  model::Point3 place = model::Point3::Zero();
  std::vector<std::uint32_t> before = {};  ///< tracks that take part, as they were before
  std::vector<std::uint32_t> after = {};
  /// Holes or cavities; of other kinds the difference of the numbers of tracks.
  std::uint64_t count = 0;
  /// What the event adds to the Euler number of the slice.
  std::int64_t euler = 0;
};

struct TrackSample {
  SolidMeasures measures;
  /// The distance from the centroid of the sample before, by the time since; none of the first.
  std::optional<double> speed = {};
};

struct Track {
  double begin = 0;
  double end = 0;
  bool beginsWithMesh = false;
  bool endsWithMesh = false;
  bool beginsBefore = false;             ///< in a part of a mesh: it exists before the part
  bool endsAfter = false;                ///< and here: after it
  bool cavity = false;                   ///< a surface that faces inward, if surfaces are tracked
  std::vector<std::uint32_t> from = {};  ///< tracks that it came out of
  std::vector<std::uint32_t> into = {};
  /// The largest volume in a sample, or at some time of its first slab if it has none.
  double largestVolume = 0;
  std::vector<TrackSample> samples = {};  ///< in the order of time
};

struct TrackOptions {
  /// At which tracks are measured, in any order.
  std::vector<double> times = {};
  /// Whether they are measured at all layers, too.
  bool layers = true;
  /// Tracks every surface for itself, those of cavities, too, instead of components of the solid.
  bool surfaces = false;
  /// A track that is smaller, or shorter, is left out where the others around it can go on without
  /// it (prune).
  double minVolume = 0;
  double minDuration = 0;
};

/// A cavity that appears in a solid and is filled again: its two events.
struct BriefCavity {
  std::size_t appears = 0;
  std::size_t vanishes = 0;
  double largestVolume = 0;  ///< in a sample
};

struct Tracks {
  model::TimeSpan time;
  std::vector<Track> tracks;       ///< in the order in which they begin
  std::vector<TrackEvent> events;  ///< in the order of time
  std::vector<BriefCavity> briefCavities;
  std::uint64_t prunedTracks = 0;
  std::uint64_t prunedEvents = 0;
};

/// Leaves out tracks with less than the least volume or duration, the shortest first: those that
/// appear and vanish, and those at a split or a merger that others take part in on the same side.
/// Where one track is left on either side the two are one from then on. Cavities that appear and
/// vanish are left out alike, unless surfaces were tracked.
void prune(Tracks& tracks, double minVolume, double minDuration);

struct PartOfTracks;

/// A track that is followed from slab to slab.
struct FollowedTrack {
  bool begun = false;
  bool ended = false;  ///< what happens at the last layer is known after the slab above it
  double begin = 0;
  double end = 0;
  /// Cells of the last slab: all of the track there, in its time, are connected with them by cells
  /// that share an edge then.
  std::vector<std::uint32_t> cells = {};
};

/// Tracks the components of a mesh, with a slab in memory and what is known of the components that
/// exist.
class Tracker : public model::Sink {
 public:
  /// `time` is that of the whole mesh; the times of samples are in order (sampleTimesOf).
  Tracker(model::TimeSpan time, std::vector<double> sampleTimes, bool surfaces);
  ~Tracker() override;

  /// Fails if checkConnectivity or checkSlab does.
  Result<void> put(const model::Slab& slab) override;
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override;

  /// Begins after this slab, which has a duration, instead of at the begin of the mesh.
  Result<void> startAfter(const model::Slab& slab);

  /// Follows a track, by its number; before the first slab.
  void follow(std::uint32_t track);
  const FollowedTrack& followed() const;

  /// Call one of them once: after the last slab of the mesh, or after a slab with a duration that
  /// others follow.
  Tracks finish();
  PartOfTracks finishPart(bool atEnd);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The times of samples of these options, in order. Fails for a time outside the mesh.
Result<std::vector<double>> sampleTimesOf(const model::Source& source, const TrackOptions& options);

/// The tracks of a closed mesh. Slabs are worked on by all threads; the result does not depend on
/// their number. Fails for a time outside the mesh, and if reading a slab does.
Result<Tracks> tracksOf(const model::Source& source, const TrackOptions& options = {},
                        const model::Progress& progress = {});

}  // namespace t4d::measure
