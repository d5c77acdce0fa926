#pragma once

#include <map>
#include <string>

namespace t4d::voxel4d {

/// Contents of volume files, for tests and fuzzers: a ball in two frames of 5 x 4 x 6 samples, x
/// fastest, with voxels of 0.5 at (-1, 2, 0.25), 0.25 apart in time where a format says so. By the
/// name of the file; `.raw` beside them are the data of detached headers.
std::map<std::string, std::string> volumeSamples();

/// The value of a sample in these: the distance from the ball, negative inside.
float volumeSample(int x, int y, int z, int frame);

/// The bytes packed by gzip.
std::string gzipped(const std::string& bytes);

}  // namespace t4d::voxel4d
