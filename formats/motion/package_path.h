#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace t4d::formats {

/// The folders of packages of ROS, by their names.
using Packages = std::map<std::string, std::filesystem::path>;

/// The file that `NAME/PATH`, the rest of package://NAME/PATH, means in a file of the folder
/// `home`, or nothing: PATH in the folder of `packages`; NAME/PATH, or PATH where the folder is the
/// package, in `home` and all folders above it and in those of ROS_PACKAGE_PATH; and
/// share/NAME/PATH in those of AMENT_PREFIX_PATH. A folder is the package if it, or the package.xml
/// in it, is called NAME. Without a NAME, as in package:///PATH, PATH is searched in all these.
std::optional<std::filesystem::path> packageFile(const std::string& rest,
                                                 const std::filesystem::path& home,
                                                 const Packages& packages);

}  // namespace t4d::formats
