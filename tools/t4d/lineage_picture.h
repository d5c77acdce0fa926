#pragma once

#include <string>

#include "tools/t4d/track.h"

namespace t4d::tools {

/// An <svg> element: time from left to right, a band for each track, as thick as its volume, and a
/// mark for each event.
std::string lineagePicture(const TrackReport& report);

}  // namespace t4d::tools
