#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::formats {

struct JoinReport {
  std::vector<BodySummary> bodies;
  std::uint64_t bytes = 0;  ///< of the file
  /// A line for each type of chunks, and each member of the metadata, that was not kept: such as
  /// this version does not know, and that may depend on the part, or differ from part to part.
  std::vector<std::string> losses;
  std::size_t parts = 0;  ///< with those that manifests name
};

/// Joins files whose times follow one another, as several processes have made them, into one
/// without decoding their slabs: the chunks are copied as they are, between one HEAD, that of the
/// first file with the features of all, and one DONE and index (SPEC.md, section "Streams and
/// parts"). A manifest (.t4dm) stands for its parts, which must be those that it describes. `into`
/// stays untouched until everything is written.
///
/// Every chunk is checked as T4dReader does with T4dOpen::Checked, and DONE against the index;
/// whether the slabs are sound is left to checkT4dFile. Fails if a file is damaged, if two differ
/// in their bodies, units, axis, space, grid or in what they say of an attribute, and if a body of
/// one does not begin as the one before it ends: with an equal LAYR, or with no layer.
Result<JoinReport> joinT4d(const std::vector<std::filesystem::path>& files,
                           const std::filesystem::path& into, const model::Progress& progress = {});

/// Writes a manifest (.t4dm) of files, which T4dReader reads like the file that joinT4d makes of
/// them. Checks the files as joinT4d does, and copies nothing. Each must have an index, and be a
/// URL or in the folder of the manifest or below. Parts that another manifest describes are trusted
/// if their size and footer match; only their indices are read. This makes it fast to merge
/// manifests that many processes wrote for one part each.
Result<JoinReport> writeManifest(const std::vector<std::filesystem::path>& files,
                                 const std::filesystem::path& into,
                                 const model::Progress& progress = {});

struct Manifest;
/// The contents of such a manifest, except for the paths of the parts.
Result<Manifest> describeParts(const std::vector<std::filesystem::path>& files,
                               const model::Progress& progress = {});

}  // namespace t4d::formats
