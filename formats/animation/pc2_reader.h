#pragma once

#include "formats/animation/point_cache.h"

namespace t4d::formats {

/// Opens a .pc2 file (3ds Max, Blender, Cinema 4D): a header of 32 bytes, "POINTCACHE2", version 1,
/// the number of points, the first frame, frames between samples, the number of samples; then the
/// samples. Times are in frames. Numbers are little-endian.
Result<PointCache> openPc2(std::unique_ptr<ByteSource> source);

}  // namespace t4d::formats
