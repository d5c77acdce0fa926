#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "t4d/error.h"

namespace t4d::tools {

struct JoinedReport {
  std::string verb;
  std::string json;   ///< as the verb prints it of the whole
  bool valid = true;  ///< false for a mesh that `validate` finds invalid
};

/// The report that a verb would have printed of the whole, from its reports on all parts of it
/// (--part K/N --json), in any order: the same numbers, except for seconds, which are added, and
/// peak memory, which is the largest. `bytes` of a file that is to be joined is null.
///
/// Fails if a file is not the report of a part, or no longer what the verb wrote, if the parts are
/// of different runs (verbs, versions, options or inputs), if one is missing or given twice, and
/// for a verb that makes files alone.
Result<JoinedReport> joinReports(const std::vector<std::filesystem::path>& files);

}  // namespace t4d::tools
