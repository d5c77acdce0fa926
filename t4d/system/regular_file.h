#pragma once

#include <cstdint>
#include <filesystem>

#include "t4d/model/error.h"

namespace t4d::system {

/// The size of a regular file in bytes. Fails if there is none, or something else: opening a pipe
/// may wait for ever, and a device may never end. To be called before an input is opened.
Result<std::uint64_t> sizeOfRegularFile(const std::filesystem::path& path);

/// Whether `file` is in `folder` or below it, once links are followed. False if it does not exist.
bool isWithinFolder(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace t4d::system
