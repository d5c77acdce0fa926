#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "t4d/error.h"

namespace t4d::formats {

/// The pairs of links that an SRDF file (a robot's semantic description, as MoveIt writes it) says
/// need no test: its <disable_collisions link1="..." link2="..."/>. Fails for what is no SRDF file,
/// and for a pair without both names, saying in which line.
Result<std::vector<std::array<std::string, 2>>> readDisabledCollisions(
    const std::filesystem::path& path);

}  // namespace t4d::formats
