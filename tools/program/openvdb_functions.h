#pragma once

#include "t4d/voxel4d/point_field.h"
#include "t4d/voxel4d/vdb_frames.h"
#include "t4d/voxel4d/voxelize.h"

/// Loading OpenVDB takes several times as long as all else that a short run does, and most verbs
/// never use it. So the program does not link it: a module, t4d_openvdb.so, has the functions of
/// t4d::voxel4d that need it, and is loaded by the first call of one of them (openvdb_loader.cpp).
/// Everything else links the library as it is.
struct OpenVdbFunctions {
  decltype(&t4d::voxel4d::openVdbFrames) openVdbFrames;
  decltype(&t4d::voxel4d::voxelFrames) voxelFrames;
  decltype(&t4d::voxel4d::writeVoxelFrames) writeVoxelFrames;
  decltype(&t4d::voxel4d::writePointField) writePointField;
};

/// What the module exports.
extern "C" const OpenVdbFunctions t4dOpenVdbFunctions;
