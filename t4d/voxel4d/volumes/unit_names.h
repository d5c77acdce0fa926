#pragma once

#include <string>
#include <string_view>

namespace t4d::voxel4d {

/// The short name of a unit of length or time: "um" for micrometer, microns, and µm with either of
/// Unicode's two characters; "s" for sec and seconds. Others as they are.
std::string unitNamed(std::string_view name);

}  // namespace t4d::voxel4d
