#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "t4d/error.h"

/// The rule for output files that the user did not name: those in an output folder, and the
/// numbered parts and companions of an output file. They replace only files that t4d wrote, and
/// never a symbolic link. (A file that the user named is replaced, also through a link, as by `>`.)
namespace t4d::platform {

/// Whether t4d wrote this file, recognized by the mark of its writers.
bool isOwnFile(const std::filesystem::path& path);

/// Fails if one of `names` in `folder` exists and must not be replaced: a symbolic link, a folder,
/// a pipe or a device, or a file for which `mayReplace` is false. Names may contain folders, which
/// must not be links either.
Result<void> checkReplaceable(
    const std::filesystem::path& folder, std::span<const std::string> names,
    const std::function<bool(const std::filesystem::path&)>& mayReplace = isOwnFile);

}  // namespace t4d::platform
