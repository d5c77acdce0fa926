#pragma once

#include <string>
#include <vector>

namespace t4d::tools {

/// A file format, for users: a row of `t4d formats` and of docs/formats.md.
struct ListedFormat {
  std::string name;
  std::string id;  ///< as `t4d convert --from` and `--to` take it; empty if they do not
  std::vector<std::string> extensions;  ///< with their dots
  std::string kind;                     ///< "4D mesh", "triangle mesh", ...
  bool reads = false;
  bool writes = false;
  std::string recognisedBy;        ///< how a file shows that it has this format
  std::vector<std::string> keeps;  ///< what it holds of what t4d knows
};

/// All formats that are read or written, from the tables of their kinds.
std::vector<ListedFormat> formatList();

}  // namespace t4d::tools
