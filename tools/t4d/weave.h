#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/weave.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/t4d_file.h"
#include "tools/t4d/weave_input.h"

namespace t4d::tools {

class Members;

struct WeaveOptions {
  voxel4d::CapStyle caps = voxel4d::CapStyle::Flat;
  voxel4d::Between between = voxel4d::Between::Distance;
  model::Part part = {};        ///< as voxel4d::WeaveOptions::part
  std::string lengthUnit = {};  ///< "" for that of the frames
  std::string timeUnit = {};    ///< "" for that of the frames
  /// The file to write. Its body is named after the input; for several labels, "label N", where the
  /// name of the options replaces "label". A part is not centred.
  T4dFileOptions output = {};
};

struct WeaveReport {
  /// The sums over all bodies. A frame is counted in one part.
  voxel4d::WeaveReport woven;
  std::uint64_t framesInBetween = 0;  ///< of the frames, those that velocities make
  std::uint64_t bytes = 0;            ///< of the file
  double seconds = 0;                 ///< with opening the frames
  std::string space;                  ///< as voxel4d::VolumeFrames::space
  std::string unsized;                ///< as voxel4d::VolumeFrames::unsized
  std::string assumedAxes;            ///< as voxel4d::VolumeFrames::assumedAxes
  std::string lengthUnit;             ///< of the mesh
  std::string timeUnit;
  bool oneApart = false;             ///< as voxel4d::FrameSource::isOneApart
  bool takenAsDistances = false;     ///< as voxel4d::VolumeFrames::takenAsDistances
  std::vector<std::string> notices;  ///< of the frames and the files
  std::vector<std::string> losses;
};

/// Weaves frames into a 4D mesh (voxel4d::weave) and writes the .t4d. Fails as voxel4d::weave does,
/// after notes of what was found in meshes; and (Options) for a file to write that is one of
/// those that were read, and for a part that is centred.
Result<WeaveReport> weave(WeaveInput input, const WeaveOptions& options,
                          Observer& observer = nobody());

void describe(Members& members, const WeaveReport& report);

}  // namespace t4d::tools
