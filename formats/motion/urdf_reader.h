#pragma once

#include <filesystem>
#include <string>

#include "formats/motion/mechanism_reader.h"
#include "formats/motion/package_path.h"

namespace t4d::formats {

struct UrdfOptions {
  /// The geometry of links that becomes solids, "collision" or "visual"; "" for "collision" or, if
  /// no link has any, "visual".
  std::string geometry = {};
  Packages packages = {};  ///< of meshes, besides those that are found (package_path.h)
  /// The pose of the robot's frame in the world, in `lengthUnit`.
  model::Pose place = {};
  std::string lengthUnit = "m";  ///< of the result
  std::string timeUnit = "s";    ///< of the result
};

/// Reads a robot (URDF, docs/mechanism.md) and a table of its joints over time (joint_table.h).
/// Each geometry of a link is a solid; lengths are in metres, times in seconds, angles in radians
/// unless the table names another unit. A planar joint has the columns `NAME.x`, `NAME.y` and
/// `NAME.angle`, which go evenly like other values; a floating one `NAME.x` to `NAME.z` and
/// `NAME.qx` to `NAME.qw`, poses joined by screws. Joints that the table does not have stay at 0,
/// with a notice; those that mimic another follow it. If the table names no joint of the robot but
/// has numbered columns (`actual_q_0`), as many as joints have values, these are the values from
/// the root on, with a notice.
///
/// Fails, with the line, on text that is not XML, links and joints that are missing, named twice or
/// have no root, cycles, unknown types of joints, meshes that cannot be read, and columns that are
/// no joint. Notices say values beyond limits of position and velocity, limits that contradict each
/// other, which are none, and joints that mimic one that is not there.
Result<LoadedMechanism> readUrdf(const std::filesystem::path& path,
                                 const std::filesystem::path& trajectory,
                                 const UrdfOptions& options = {});
Result<LoadedMechanism> readUrdf(const InputFile& file, const InputFile& trajectory,
                                 const UrdfOptions& options = {});

}  // namespace t4d::formats
