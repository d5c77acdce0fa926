#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "platform/file_format.h"

namespace t4d::voxel4d {

/// The formats of OpenVDB. Inline, as vdb_frames.cpp needs that library.
inline std::vector<platform::FileFormat> vdbFormats() {
  return {{"OpenVDB", {".vdb"}, {"level sets", "densities", "masks"}, true}};
}

/// The formats that openVolumeFrames reads: arrays of samples, as scanners and simulations write
/// them.
std::vector<platform::FileFormat> volumeFormats();

/// The extensions of all of these, with their dots.
std::vector<std::string_view> volumeExtensions();

/// Whether a file is one of these, by its extension.
bool isVolumeFile(const std::filesystem::path& path);

}  // namespace t4d::voxel4d
