#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "t4d/file.h"

namespace t4d::tools {

class Members;

struct InfoOptions {
  bool slabs = false;  ///< list what each slab contains
};

/// The contents of a .t4d file.
struct InfoReport {
  std::string name;  ///< for messages: the path, or the URL without credentials
  formats::T4dVersion version;
  bool indexed = false;
  std::uint64_t bytes = 0;  ///< of the file
  formats::Metadata metadata = {};
  std::vector<formats::T4dChunks> chunks = {};    ///< as formats::T4dReader::chunks
  std::vector<formats::BodySummary> bodies = {};  ///< at least one, each with its name in metadata
  /// The slabs of each body, in time order, if they were asked for.
  std::vector<std::vector<formats::T4dSlab>> slabs = {};

  /// The sums over all bodies, the bounds of all, and the first and last time of any.
  formats::BodySummary total() const;
};

/// Reads the header and the index of a .t4d file, a path or a URL. Of one without an index, and of
/// a pipe ("-" is the standard input), all is read and checked. Any number of cells is accepted.
Result<InfoReport> info(const std::string& path, const InfoOptions& options = {});

void describe(Members& members, const InfoReport& report);

}  // namespace t4d::tools
