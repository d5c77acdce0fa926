#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::formats {

struct MergeReport {
  /// A body of the merged file.
  struct Body {
    std::string name;
    std::size_t file = 0;  ///< that it is from
    BodySummary summary = {};
  };
  std::vector<Body> bodies;
  std::uint64_t bytes = 0;           ///< of the file
  std::vector<std::string> notices;  ///< bodies that were renamed, a sentence each
  std::vector<std::string> losses;   ///< as JoinReport::losses
};

/// Puts the bodies of several files into one, without decoding their slabs: the chunks are copied
/// as they are, and only SLABs get another number of their body. Keeps one chunk in memory. `into`
/// stays untouched until everything is written. Of bodies of one name, the second and further ones
/// are renamed, "arm 2", with a notice; parents that are named follow.
///
/// The files are checked as joinT4d does. Fails if one is damaged, if two differ in their units,
/// axis, space, grid or in what they say of an attribute, and for more bodies than a file can have.
Result<MergeReport> mergeT4d(const std::vector<std::filesystem::path>& files,
                             const std::filesystem::path& into,
                             const model::Progress& progress = {});

}  // namespace t4d::formats
