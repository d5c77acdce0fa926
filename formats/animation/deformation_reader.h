#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "platform/file_format.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// A solid that is deformed.
struct LoadedDeformation {
  /// The solid at rest: the first mesh of a series, or the mesh beside a cache. It keeps the look
  /// of the surface: `color`, `uv` and `material`.
  LoadedMesh solid;
  std::unique_ptr<model::VertexKeys> keys;
  /// The file of each key of a series, for errors; empty for a point cache.
  std::vector<std::filesystem::path> files = {};
  bool timed = false;  ///< the times are from a file
};

/// The times of keys: evenly spaced between two times, or apart by `step` from 0 on. Without
/// either, the file's own; meshes that no collection lists have none and are 1 apart.
struct KeyTimes {
  std::optional<model::TimeSpan> between = {};
  std::optional<double> step = {};
};

/// Reads meshes of the same triangles, one key each: those that a collection (.pvd) lists, in the
/// order of their times, or files in the order given. One mesh besides the first is in memory at a
/// time; all others are read when their key is asked for, and fail then if they are no mesh of the
/// same points and faces. Also fails if checkNumbers does.
Result<LoadedDeformation> readMeshSeries(std::span<const std::filesystem::path> files,
                                         const KeyTimes& times);

/// Reads a mesh and the point cache of its vertices, .pc2 or .mdd by the extension. The cache has
/// as many points as the mesh's file, in the same order. One sample is in memory at a time.
Result<LoadedDeformation> readCachedMesh(const std::filesystem::path& mesh,
                                         const std::filesystem::path& cache, const KeyTimes& times);

/// PC2 and MDD.
std::vector<platform::FileFormat> pointCacheFormats();

/// True for the name of a .pc2 or .mdd file.
bool isPointCache(const std::filesystem::path& path);

}  // namespace t4d::formats
