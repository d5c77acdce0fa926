#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/weave.h"

namespace t4d::tools {

/// The notice for meshes that say no times.
inline constexpr const char* kMeshesAreOneApart =
    "meshes have no times: frames are taken to be 1 apart; give the time between frames to change "
    "that";

/// True for the name of a triangle mesh that is read, or of a collection (.pvd) of them.
bool isMeshFrame(const std::string& path);

/// Findings in the meshes of a series while they were read.
struct MeshFramesLog {
  std::vector<std::string> notices;
  std::vector<std::string> losses;  ///< each once, however many meshes have it
  std::vector<std::string> files;   ///< the meshes, and those that were read besides
};

struct MeshFrames {
  std::unique_ptr<voxel4d::FrameSource> frames;
  std::shared_ptr<MeshFramesLog> log;
};

struct MeshFramesOptions {
  double voxelSize = 1;
  /// Without it, frames have the times of the collection, or are 1 apart, with a notice.
  std::optional<double> frameTime = {};
  double startTime = 0;
  std::vector<double> times = {};  ///< one for each mesh, increasing; empty for none
};

/// Level sets of triangle meshes, a frame each, in the order of formats::meshSteps. A mesh is read
/// and voxelized when its frame is requested; they need not have the same triangles. Errors of a
/// mesh name its file.
Result<MeshFrames> openMeshFrames(const std::vector<std::string>& files,
                                  const MeshFramesOptions& options);

}  // namespace t4d::tools
