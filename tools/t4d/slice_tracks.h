#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/surface.h"
#include "tools/t4d/track.h"

namespace t4d::tools {

/// The name of the attribute of triangles that has the id of their track.
inline constexpr std::string_view kTrack = "track";

/// The colour of a track, by its id: that of a number far from its neighbours
/// (convert::distinctColor), or grey for 0.
formats::Color trackColor(std::uint64_t id);

/// Finds out which track each triangle of a slice belongs to. A component of the slice at a time is
/// the track whose sample at that time has the same bounds.
class SliceTracks {
 public:
  /// The slices to ask about are those at the times of the report's samples.
  explicit SliceTracks(const TrackReport& report);

  /// The id of the track of each triangle of an exact slice of a body, that of a cavity being the
  /// id of the solid around it; 0 for what was left out of the report.
  std::vector<std::uint64_t> of(const std::string& body, const model::TriangleMesh& slice,
                                double time) const;

 private:
  struct Place {
    std::uint64_t track;
    model::Bounds3 bounds;
  };
  std::map<std::string, std::map<double, std::vector<Place>>> places_;  // by body and time
};

}  // namespace t4d::tools
