#pragma once

#include <vector>

#include "tools/t4d/input.h"

namespace t4d::tools {

/// The times of the frames that a mesh was made of, increasing: those of the layers of all bodies.
/// Of a woven mesh neither caps half a frame beyond the ends nor steps of velocities between frames
/// count; of a swept mesh they are the ends of its steps.
std::vector<double> frameTimesOf(const Input& input);

}  // namespace t4d::tools
