#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct CompressOptions {
  std::string output = {};  ///< the .t4d to write
  formats::T4dWriteOptions writing = {.compression = 19};
  model::Part part = {};       ///< the share of the slabs of each body that is written (partOf)
  std::string generator = {};  ///< program and version, for the metadata
};

struct CompressReport {
  std::uint64_t bytesBefore = 0;  ///< of the file; 0 for a mesh in memory
  std::uint64_t bytes = 0;
  double seconds = 0;
  std::vector<std::string> losses = {};  ///< as formats::T4dWriter::losses
};

/// Writes the same mesh again, stored in another way.
Result<CompressReport> compress(const Input& input, const CompressOptions& options,
                                Observer& observer = nobody());

void describe(Members& members, const CompressReport& report);

}  // namespace t4d::tools
