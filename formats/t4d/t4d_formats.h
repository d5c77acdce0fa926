#pragma once

#include <vector>

#include "platform/file_format.h"

namespace t4d::formats {

/// Our own, in one file or in parts.
std::vector<platform::FileFormat> t4dFormats();

}  // namespace t4d::formats
