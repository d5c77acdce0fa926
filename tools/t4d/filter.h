#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/time_window.h"

namespace t4d::tools {

class Members;

struct FilterOptions {
  TimeWindow window = {};
  /// Keeps this track alone through its life, by its id (track, nothing left out), instead
  /// of a time window.
  std::optional<std::uint64_t> track = {};
  std::string output = {};     ///< the .t4d to write
  int compression = 3;         ///< as formats::T4dWriteOptions::compression
  std::string generator = {};  ///< program and version, for the metadata
};

/// A cap that closes a body at a time.
struct FilterCap {
  std::string body;
  double time = 0;
  std::uint64_t triangles = 0;
  std::uint64_t cells = 0;
};

struct FilterReport {
  std::uint64_t bodies = 0;
  model::TimeSpan span = {};
  std::uint64_t slabs = 0;     ///< without caps
  std::uint64_t slabsCut = 0;  ///< those of them that were cut at an end of the span
  std::uint64_t cells = 0;     ///< with those of caps
  std::vector<FilterCap> caps = {};
  std::uint64_t bytes = 0;
  double seconds = 0;
  std::vector<std::string> notices = {};  ///< on bodies that are left out
  std::vector<std::string> losses = {};   ///< as formats::T4dWriter::losses

  std::uint64_t capCells() const;
};

/// Writes the part of the bodies that is within the time window (edit::clipTime), or a track of one
/// of them (edit::cutTrack). Fails with Remedy::OtherBodies if a body exists then but has no cell,
/// and if there is no such track.
Result<FilterReport> filter(const Input& input, const FilterOptions& options,
                            Observer& observer = nobody());

void describe(Members& members, const FilterReport& report);

}  // namespace t4d::tools
