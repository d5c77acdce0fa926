#pragma once

#include <string>
#include <vector>

/// Small .vdb files for tests and fuzzers.
namespace t4d::voxel4d {

struct VdbSample {
  std::string name;
  std::string bytes;
};

/// Float, double, int32, bool and mask grids in every encoding of OpenVDB: all compressions, half
/// floats, all encodings of inactive values, with offsets and streamed, several grids, shared
/// trees.
std::vector<VdbSample> vdbSamples();

}  // namespace t4d::voxel4d
