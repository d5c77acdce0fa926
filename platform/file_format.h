#pragma once

#include <string_view>
#include <vector>

namespace t4d::platform {

/// A file format as `t4d formats` and docs/formats.md list it. Its row is beside what reads it.
struct FileFormat {
  std::string_view name;
  std::vector<std::string_view> extensions;  ///< with their dots, in lower case
  std::vector<std::string_view> keeps;       ///< what it holds of what t4d knows
  bool writes = false;
  std::string_view recognisedBy = "the extension";  ///< how a file shows that it has this format
  bool reads = true;
  std::string_view id = {};  ///< as `t4d convert --from` and `--to` take it; empty if they do not
};

}  // namespace t4d::platform
