#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/track.h"

namespace t4d::tools {

/// The points at which labels are taken.
struct LabelLattice {
  model::Point3 spacing = model::Point3::Ones();  ///< between points, along x, y and z
  /// The position of the first point; without it, half a spacing from the least corner of the
  /// mesh's bounds.
  std::optional<model::Point3> origin = {};
  /// Points along x, y and z; without it, up to the end of the mesh's bounds.
  std::optional<std::array<std::uint32_t, 3>> size = {};
};

struct CtcReport {
  std::uint64_t frames = 0;
  std::uint64_t labels = 0;
  model::Point3 origin = model::Point3::Zero();
  std::array<std::uint32_t, 3> size = {};
  /// Further tracks that merge into others: a label has one parent.
  std::uint64_t lostLinks = 0;
};

/// Writes tracks as the Cell Tracking Challenge has them: `mask000.tif` and so on, which have the
/// label of the track at each lattice point inside the solid, and `res_track.txt`, with a line
/// "label first-frame last-frame parent" for each label. A label is the id of a track; one that has
/// no lattice point for some frames goes on as a new label, whose parent it is. Where bodies
/// overlap, the last one has the point. A frame and a slice are in memory at a time.
///
/// `report` has samples at `times`, which increase. Fails if the folder has files of others, if
/// there are more than 65535 labels, or more than 2^31 lattice points, and if slicing or writing
/// does.
Result<CtcReport> writeCtc(const Input& input, const TrackReport& report,
                           const std::vector<double>& times, const LabelLattice& lattice,
                           const std::string& folder, Observer& observer = nobody());

}  // namespace t4d::tools
