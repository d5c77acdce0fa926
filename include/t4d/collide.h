#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "t4d/mesh.h"

/// Contact and clearance of two moving solids, decided on their 4D meshes.
namespace t4d::measure {

/// A cell of a body.
struct CellNumber {
  std::uint64_t slab = 0;
  std::uint64_t cell = 0;  ///< of the slab
};

/// A common point of two solids at a time.
struct Contact {
  double time = 0;
  model::Point3 point = model::Point3::Zero();
  /// The cells that meet there. Where one solid appears inside the other, only its own cell is
  /// given.
  std::optional<CellNumber> a;
  std::optional<CellNumber> b;
};

/// A time during which two solids have common points.
struct ContactInterval {
  double begin = 0;
  double end = 0;
  Contact first;  ///< at `begin`
  /// Whether the interiors of the solids have common points at some time in it; if not, they only
  /// touch.
  bool overlaps = false;
  /// A time in it during which the interiors certainly have common points, if that is known of any;
  /// otherwise the whole interval.
  model::TimeSpan crossing{0, 0};
  double deepestTime = 0;    ///< when the overlap is largest; `begin` if they only touch
  double overlapVolume = 0;  ///< the volume of the overlap then
  double volumeError = 0;    ///< an estimate of its error
};

/// The smallest distance of two solids at equal times.
struct Clearance {
  double distance = 0;    ///< between pointA and pointB, which are points of the two solids
  double lowerBound = 0;  ///< at no time are two points of the solids nearer
  double time = 0;
  model::Point3 pointA = model::Point3::Zero();
  model::Point3 pointB = model::Point3::Zero();
  CellNumber a;
  CellNumber b;
};

/// The smallest distance of two solids at equal times within a span.
struct ClearanceOver {
  model::TimeSpan span;
  double distance = 0;  ///< 0 for solids in contact
};

struct CollideOptions {
  /// Find the smallest distance of solids that never meet.
  bool clearance = true;
  /// Find it for each part of the time between two layers of either solid, too.
  bool clearanceOverTime = false;
  /// Find the largest overlap of each interval. Without this, deepestTime is the middle
  /// of `crossing`, overlapVolume is not known, and intervals in which no two cells cross and no
  /// part of a solid lies inside the other count as touching.
  bool overlapVolumes = true;
};

struct Collision {
  /// The times when both solids exist; nothing if there are none.
  std::optional<model::TimeSpan> common;
  std::vector<ContactInterval> intervals;  ///< in time order, apart from each other
  std::optional<Clearance> clearance;      ///< of solids that exist together and never meet
  std::vector<ClearanceOver> clearanceOverTime;

  bool contact() const { return !intervals.empty(); }
};

/// When two solids touch or overlap, and how near they come if they do neither.
///
/// Exact for the 4D meshes, which bound closed solids: between their layers, surfaces move as the
/// cells say. Times of contact are those at which two cells meet (cell_pair.h), and those at which
/// a connected part of one surface lies inside the other solid. Whether cells meet is never decided
/// by an epsilon; intervals that are apart by no more than the rounding of their times
/// (model::kSameTimeUlps) are one.
///
/// Cells at a constant time, as those of caps, are left out. Where they bound a solid in time,
/// their boundary belongs to other cells, and what lies in them is inside.
///
/// Streams both meshes in time order; a slab of each is in memory at a time, with a tree of boxes
/// over its cells, which is built once for all slabs that share their connectivity. Works on all
/// threads; the result does not depend on their number. Fails if a source does.
Result<Collision> collide(const model::Source& a, const model::Source& b,
                          const CollideOptions& options = {}, const model::Progress& progress = {});

/// Two of several bodies.
struct SourcePair {
  const model::Source* a = nullptr;
  const model::Source* b = nullptr;
};

/// Collides several pairs; returns what `collide` returns for each, in their order. Work on a body
/// is shared by all its pairs: one slab of each body is in memory at a time, with its tree. Pairs
/// with disjoint bounding boxes cost almost nothing.
Result<std::vector<Collision>> collideAll(std::span<const SourcePair> pairs,
                                          const CollideOptions& options = {},
                                          const model::Progress& progress = {});

}  // namespace t4d::measure
