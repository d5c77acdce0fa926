#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "t4d/file.h"

namespace t4d::tools {

class Members;

/// The uses of the bytes of a .t4d file.
struct DuReport {
  std::string name;  ///< for messages: the path, or the URL without credentials
  std::uint64_t bytes = 0;
  std::uint64_t tetrahedra = 0;                 ///< of all bodies
  std::vector<formats::T4dChunks> chunks = {};  ///< the largest first
  std::uint64_t otherBytes = 0;                 ///< of the header and the footer

  /// `ofBytes` per tetrahedron; 0 for an empty mesh.
  double perTetrahedron(std::uint64_t ofBytes) const;
};

/// Reads the file as info does.
Result<DuReport> du(const std::string& path);

void describe(Members& members, const DuReport& report);

}  // namespace t4d::tools
