#pragma once

#include <array>

/// Names of the metadata of a grid that is a part of a field. For the sources of this folder only.
namespace t4d::voxel4d {

inline constexpr const char* kPartNumber = "t4d_part_number";
inline constexpr const char* kPartCount = "t4d_part_count";
/// Points of the whole field along each axis.
inline constexpr std::array<const char*, 3> kPartPoints = {"t4d_points_x", "t4d_points_y",
                                                           "t4d_points_z"};
/// The beginning of the names of what tells one run from another.
inline constexpr const char* kPartRun = "t4d_run_";

}  // namespace t4d::voxel4d
