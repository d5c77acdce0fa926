#pragma once

#include <vector>

#include "platform/file_format.h"

namespace t4d::formats {

/// Our JSON and tables of poses.
std::vector<platform::FileFormat> motionFormats();

}  // namespace t4d::formats
