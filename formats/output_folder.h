#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "t4d/error.h"

namespace t4d::formats {

/// Writes a file of a folder, whole or not at all, and makes the folders on the way. Replaces any
/// file, but no symbolic link (system/replaceable.h).
Result<void> writeInFolder(const std::filesystem::path& folder, const std::string& name,
                           std::string_view bytes);

/// Makes a folder for files that bear no mark of t4d. One that exists must be empty or made by this
/// function, which leaves a file `.t4d-kept` in it.
Result<void> makeKeptFolder(const std::filesystem::path& folder);

}  // namespace t4d::formats
