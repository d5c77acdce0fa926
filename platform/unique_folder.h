#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace t4d::platform {

/// Makes a folder in `parent` with a name that nothing has there and that begins so; others may not
/// look into it. None if it fails, and then errno says why.
std::optional<std::filesystem::path> makeUniqueFolder(const std::filesystem::path& parent,
                                                      const std::string& prefix);

}  // namespace t4d::platform
