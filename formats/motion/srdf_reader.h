#pragma once

#include <array>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "t4d/error.h"

namespace t4d::formats {

/// The pairs of links in an SRDF file (a robot's semantic description, as MoveIt writes it).
struct DisabledCollisions {
  using Pair = std::array<std::string, 2>;

  std::vector<Pair> pairs = {};      ///< that need no test: <disable_collisions>
  std::set<std::string> links = {};  ///< without test: <disable_default_collisions>
  std::set<Pair> enabled = {};  ///< of these, pairs with one: <enable_collisions>, in both orders

  /// Whether two links need no test.
  bool contains(const std::string& a, const std::string& b) const;
  /// All links that are named.
  std::set<std::string> names() const;
};

/// Fails for what is no SRDF file, and where a name is missing, saying in which line.
Result<DisabledCollisions> readDisabledCollisions(const std::filesystem::path& path);

}  // namespace t4d::formats
