#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "convert/frame_slices.h"
#include "t4d/convert.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::convert {

/// The names of numbered files.
struct FrameNames {
  std::filesystem::path folder = {};
  std::string stem = "frame_";  ///< before the number
  std::size_t digits = 4;       ///< minimum; more if the last number needs more
  std::string extension = {};   ///< of a triangle mesh format that can be written
  std::string manifest = "manifest.json";
  std::string collection = "frames.pvd";  ///< for .vtp files; "frames.usda" for .usda files

  /// "folder/frame_0042.ply"
  std::string fileName(std::uint64_t number, std::uint64_t count) const;
};

/// `output` is a folder, for files frame_0000 and so on with `extension`, or the pattern of a file
/// with %d or %04d for the number, such as "out/bolt_%04d.ply". A pattern's manifest and collection
/// are named after it, here bolt.manifest.json and bolt.pvd, so that several series can share a
/// folder. Fails for a pattern with another extension than `extension`, unless that is empty, and
/// for an extension that is not of a triangle mesh format that can be written.
Result<FrameNames> frameNames(const std::string& output, std::string_view extension);

/// The units, axes and rate of all frames, for the manifest.
struct FrameSpace {
  std::string lengthUnit = {};  ///< "" if unknown
  std::string timeUnit = {};
  std::string up = "y";
};

struct FrameFilesOptions {
  slice::SliceDetail detail = slice::SliceDetail::Exact;
  formats::MeshWriteOptions write = {};
  Paint paint = {};
  std::optional<FrameVelocity> velocity = {};
  FrameSpace space = {};
  /// The share of the frames that is written, under the names that they have in the whole series;
  /// the manifest is named after the part, and there is no collection (joinManifests).
  model::Part part = {};
  double framesPerSecond = 24;  ///< of playback, in .usda
};

struct FrameFilesReport : FrameSlicesReport {
  std::uint64_t bytes = 0;  ///< of all frames
};

/// Writes the solid at each of `times` to a file of its own (formats::writeTriangleMeshes) and,
/// when all are written, the manifest: a JSON object with the time, triangles and volume of each
/// (frames_manifest.schema.json). For .vtp there is also a ParaView collection (.pvd), which has
/// the times; for .usda a layer that has all files as a value clip set. An old manifest or
/// collection is removed first, so a series with a manifest is complete. Creates the folder. Fails
/// if the folder has other files that look like frames of this series, and if forEachFrame or
/// writing fails.
Result<FrameFilesReport> writeFrameFiles(std::span<const model::Body> bodies,
                                         std::span<const double> times, const FrameNames& names,
                                         const FrameFilesOptions& options = {},
                                         const model::Progress& progress = {});

/// "manifest.part-2-of-8.json" of "manifest.json".
std::string manifestOfPart(const std::string& manifest, const model::Part& part);

/// A file of a series, in its manifest.
struct FrameEntry {
  std::string file = {};  ///< its name, beside the manifest
  double time = 0;
  std::optional<std::uint64_t> vertices = {};  ///< for a grid nothing, as for `triangles`
  std::optional<std::uint64_t> triangles = {};
  double volume = 0;
  std::uint64_t bytes = 0;
};

struct FramesManifest {
  model::Part part = {};        ///< of which it lists the frames
  std::uint64_t of = 0;         ///< with a part: the number of all frames
  std::string collection = {};  ///< with a part: the .pvd that lists all frames; "" for none
  FrameSpace space = {};
  model::Point3 origin = model::Point3::Zero();  ///< of the files, in the original coordinates
  bool light = false;
  double distance = 0;
  std::vector<FrameEntry> frames = {};
};

/// Writes the manifest of a series of files, as writeFrameFiles does.
Result<void> writeManifest(const std::filesystem::path& path, const FramesManifest& manifest);

/// Writes the manifest of a series from those of all its parts, in any order, and the collection
/// that they name, beside it. Fails if a part is missing or there twice, or if they are of
/// different series.
Result<std::uint64_t> joinManifests(const std::vector<std::filesystem::path>& parts,
                                    const std::filesystem::path& into);

/// Removes the manifest or the collection, if any, of a series that is about to be replaced.
Result<void> removeOldManifest(const std::filesystem::path& path);

}  // namespace t4d::convert
