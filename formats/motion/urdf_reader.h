#pragma once

#include <filesystem>
#include <string>

#include "formats/motion/mechanism_reader.h"

namespace t4d::formats {

struct UrdfOptions {
  /// The geometry of links that becomes solids: "collision" or "visual".
  std::string geometry = "collision";
};

/// Reads a robot (URDF, docs/mechanism.md) and a table of its joints over time (joint_table.h).
/// Each geometry of a link is a solid; lengths are in metres, times in seconds, angles in radians
/// unless the table names another unit. Meshes named package://NAME/PATH are looked for in the
/// folders that contain the file. Joints that the table does not have stay at 0, with a notice;
/// those that mimic another follow it.
///
/// Fails, with the line, on text that is not XML, links and joints that are missing, named twice or
/// have no root, cycles, types of joints that are not supported (floating, planar), limits that are
/// not, meshes that cannot be read, and columns that are no joint. Values beyond limits of position
/// and velocity are notices.
Result<LoadedMechanism> readUrdf(const std::filesystem::path& path,
                                 const std::filesystem::path& trajectory,
                                 const UrdfOptions& options = {});
Result<LoadedMechanism> readUrdf(const InputFile& file, const InputFile& trajectory,
                                 const UrdfOptions& options = {});

}  // namespace t4d::formats
