#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "platform/file_format.h"
#include "t4d/surface.h"

/// A series of triangle meshes: numbered files, or those that a collection (.pvd) lists.
namespace t4d::formats {

/// A mesh at a time, in one file or in several parts.
struct MeshStep {
  double time = 0;
  std::vector<std::filesystem::path> files;
};

struct MeshSteps {
  std::vector<MeshStep> steps;
  bool timed = false;  ///< the times are from a file; otherwise they are 0, 1, ...
};

/// ParaView's .pvd, which lists meshes with their times.
std::vector<platform::FileFormat> collectionFormats();

/// True for the name of a .pvd file.
bool isCollection(const std::filesystem::path& path);

/// The steps of a single collection in the order of their times, or of mesh files in the order
/// given. Fails if there are fewer than two, and for a collection with another mistake, or a file
/// that is missing, no triangle mesh by its extension, or not in the folder of the collection or
/// below.
Result<MeshSteps> meshSteps(std::span<const std::filesystem::path> files);

/// Reads the mesh of a step. Several parts become one mesh as the pieces of a file do: points with
/// equal coordinates are one vertex, and attributes of parts are losses.
Result<LoadedMesh> readMeshStep(const MeshStep& step, Keep keep = Keep::Shape);

}  // namespace t4d::formats
