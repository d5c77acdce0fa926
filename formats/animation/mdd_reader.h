#pragma once

#include "formats/animation/point_cache.h"

namespace t4d::formats {

/// Opens an .mdd file (LightWave, Blender, Houdini): the number of samples, the number of points,
/// a float32 time for each sample, in seconds; then the samples. Numbers are big-endian.
Result<PointCache> openMdd(std::unique_ptr<ByteSource> source);

}  // namespace t4d::formats
