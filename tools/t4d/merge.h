#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/t4d/merge.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct MergeReport : formats::MergeReport {
  std::vector<std::string> files;  ///< as given, by the numbers in `bodies`

  std::uint64_t vertices() const;
  std::uint64_t tetrahedra() const;
};

/// Puts the bodies of .t4d files into one file (formats::mergeT4d).
Result<MergeReport> merge(const std::vector<std::string>& files, const std::string& output,
                          Observer& observer = nobody());

void describe(Members& members, const MergeReport& report);

}  // namespace t4d::tools
