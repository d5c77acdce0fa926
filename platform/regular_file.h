#pragma once

#include <cstdint>
#include <filesystem>

#include "t4d/error.h"

namespace t4d::platform {

/// The size of a regular file in bytes, which is noted as an input of the run (kept_inputs.h).
/// Fails if there is no such file, or if it is not a regular file. To be called before an input is
/// opened, since opening a pipe may wait forever, and a device may never end.
Result<std::uint64_t> sizeOfRegularFile(const std::filesystem::path& path);

/// Whether `file` is in `folder` or below it, with links followed. False if it does not exist.
bool isWithinFolder(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace t4d::platform
