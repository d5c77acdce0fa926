#include "tools/t4d/modules.h"

extern "C" const OpenVdbFunctions t4dOpenVdbFunctions = {
    &t4d::voxel4d::openVdbFrames,   &t4d::voxel4d::advectedFrames,
    &t4d::voxel4d::voxelFrames,     &t4d::voxel4d::writeVoxelFrames,
    &t4d::voxel4d::writePointField, &t4d::voxel4d::joinPointFields};
