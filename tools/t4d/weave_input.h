#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/frames.h"
#include "tools/t4d/mesh_frames.h"
#include "voxel4d/frame_formats.h"

namespace t4d::tools {

/// The contents of files of frames.
enum class FrameKind : std::uint8_t {
  Vdb,      ///< grids of OpenVDB, or a folder of their files
  Volumes,  ///< voxel4d::volumeFormats, or `-`, a stream of frames
  Meshes,   ///< triangle meshes, or a collection (.pvd) of them
};

/// ".nrrd, .nhdr, ...".
std::string volumeExtensions();

/// The notice that names are what orders frames, with the names of the first and the last.
std::string orderNotice(const std::string& first, const std::string& last);

/// The kind of all of these files, by their names and the contents of folders. What is neither a
/// volume nor a mesh is Vdb. Fails for no files, files of several kinds (Options), a folder that
/// holds volumes and no .vdb file, and a mesh of a format that is only written.
Result<FrameKind> frameKindOf(std::span<const std::string> files);

/// Options for reading frames from files. Options for another kind of frames have no effect.
struct FrameReading {
  /// Options for reading volumes, except `label` and `region`. Its times are for all kinds of
  /// frames (the start of .vdb files needs the time between frames), its `iso` and `below` for .vdb
  /// files, too.
  voxel4d::VolumeOptions volumes = {};
  /// Labels of volumes; each is a body. Without any, what is inside is one body.
  std::vector<std::int64_t> labels = {};
  bool allLabels = false;  ///< all that there are (voxel4d::labelsOf) instead of `labels`
  /// Samples and frames to use, as voxel4d::parseRegion takes them; "" for all. Not with a velocity
  /// and not of meshes.
  std::string region = {};
  std::string grid = {};                        ///< as voxel4d::VdbFramesOptions::grid
  std::string velocity = {};                    ///< as voxel4d::VdbFramesOptions::velocity
  std::vector<std::string> velocityFiles = {};  ///< of volumes, as voxel4d::openVolumeVelocity
  /// With a velocity: steps from one frame to the next, with a frame in between after each but the
  /// last.
  std::uint32_t substeps = 4;
  std::optional<double> voxelSize = {};  ///< of meshes, which need it; in length units

  bool hasVelocity() const { return !velocity.empty() || !velocityFiles.empty(); }
  /// Steps from one frame of the files to the next.
  std::uint32_t steps() const { return hasVelocity() ? substeps : 1; }
};

/// Frames of one solid or more: of files (openFrames), or in memory, with a name and the frames of
/// the only body.
struct WeaveInput {
  std::string name;              ///< for messages and metadata
  voxel4d::VolumeFrames frames;  ///< of the first body
  std::vector<std::string> files = {};
  FrameReading reading = {};  ///< of the files
  /// Findings in triangle meshes while frames are requested; null for other frames.
  std::shared_ptr<const MeshFramesLog> meshes = nullptr;
  double seconds = 0;  ///< that opening took
  /// Decisions made about frames before they are read.
  std::vector<std::string> notices = {};
};

/// Opens frames, which are read when they are requested; all labels are found by reading them once
/// before. Files stay in the order given; those of a folder are in natural order of their names,
/// which a notice says unless the files have times. Fails if frameKindOf does, for meshes without a
/// voxel size, a region that cannot be parsed or that comes with a velocity, and as
/// voxel4d::openVdbFrames, voxel4d::openVolumeFrames and openMeshFrames do.
Result<WeaveInput> openFrames(std::vector<std::string> files, FrameReading reading);

/// The frames of a label, which is another body of the same volumes.
Result<voxel4d::VolumeFrames> framesOfLabel(const WeaveInput& input, std::int64_t label);

}  // namespace t4d::tools
