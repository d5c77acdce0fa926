#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "voxel4d/velocity.h"

namespace t4d::voxel4d {

/// The names of the grids of a velocity in a file: `name`, if there is such a grid, else its three
/// components.
Result<std::vector<std::string>> vdbVelocityGrids(const std::filesystem::path& file,
                                                  const std::string& name);

/// The velocities of `frames` frames on `lattice` from these grids, which are placed among the
/// files as those of frames are. Their own lattices may have other voxels; values between their
/// points are interpolated. A velocity is known where it is stored as active and is not zero.
Result<std::unique_ptr<VelocitySource>> openVdbVelocity(
    std::span<const std::filesystem::path> files, std::span<const std::string> grids,
    const Lattice& lattice, std::size_t frames);

}  // namespace t4d::voxel4d
