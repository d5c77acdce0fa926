#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "t4d/weave.h"

/// Names of the choices of voxel4d::WeaveOptions, for users and metadata.
namespace t4d::tools {

/// Names in the order of voxel4d::CapStyle.
inline constexpr std::array<std::string_view, 3> kCapStyleNames = {"flat", "half-step", "graded"};

/// Names in the order of voxel4d::Between.
inline constexpr std::array<std::string_view, 2> kBetweenNames = {"distance", "midpoint"};

constexpr std::string_view nameOfCaps(voxel4d::CapStyle caps) {
  return kCapStyleNames[static_cast<std::size_t>(caps)];
}

constexpr std::string_view nameOfBetween(voxel4d::Between between) {
  return kBetweenNames[static_cast<std::size_t>(between)];
}

/// The style of this name; nothing for another name.
constexpr std::optional<voxel4d::CapStyle> capStyleOf(std::string_view name) {
  const auto found = std::ranges::find(kCapStyleNames, name);
  if (found == kCapStyleNames.end()) return std::nullopt;
  return static_cast<voxel4d::CapStyle>(found - kCapStyleNames.begin());
}

constexpr std::optional<voxel4d::Between> betweenOf(std::string_view name) {
  const auto found = std::ranges::find(kBetweenNames, name);
  if (found == kBetweenNames.end()) return std::nullopt;
  return static_cast<voxel4d::Between>(found - kBetweenNames.begin());
}

}  // namespace t4d::tools
