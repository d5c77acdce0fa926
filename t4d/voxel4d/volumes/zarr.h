#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "t4d/system/web_files.h"
#include "t4d/voxel4d/volumes/volume.h"

namespace t4d::voxel4d {

struct ZarrChoice {
  std::string axes;  ///< "" for what it says
  std::uint32_t level = 0;
  std::optional<std::uint32_t> channel;
};

/// Whether it is a URL, or a folder that holds metadata of Zarr or has .zarr in its path.
bool isZarr(const std::filesystem::path& path);

/// An array of Zarr, version 2 or 3, or an image of OME-Zarr, of which one level is read: a folder,
/// or a URL if `web` can request files.
Result<Volume> readZarr(const std::filesystem::path& path, const ZarrChoice& choice,
                        const system::WebFiles& web);

/// Fails for frames that are larger than memory or than what is stored of the array could be, and
/// for far more chunks than are stored. Counts what is to be read of a volume of Zarr.
Result<void> checkZarrAmount(const Volume& volume);

}  // namespace t4d::voxel4d
