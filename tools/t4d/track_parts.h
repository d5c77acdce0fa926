#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "measure/track_parts.h"
#include "t4d/mesh.h"
#include "tools/t4d/track.h"

/// Tracking a file in parts, each by another process. A part takes its share of the slabs of each
/// body, and one more; what all of them found together is what `track` finds.
namespace t4d::tools {

struct TrackedPart {
  TrackReport report;  ///< with ids that go on from body to body within the part
  /// For each body, the rest of measure::PartOfTracks.
  std::vector<measure::PartOfTracks> seams = {};
};

/// Tracks the components of each body in a part of its slabs. Nothing is left out.
Result<TrackedPart> trackPart(const Input& input, const measure::TrackOptions& options,
                              const model::Part& part, Observer& observer = nobody());

/// The data of a part besides its report that `joinedTracking` needs.
nlohmann::ordered_json stateOf(const TrackedPart& part, const measure::TrackOptions& options);

/// The report on all slabs from those on the parts, whose members `part` have the states. Throws
/// nlohmann::json::exception for anything but such reports; fails as measure::joinedTracks does.
Result<TrackReport> joinedTracking(const std::vector<nlohmann::ordered_json>& reports);

}  // namespace t4d::tools
