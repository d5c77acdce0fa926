#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/file_format.h"

namespace t4d::tools {

class Members;

/// The file formats of one kind of data.
struct FormatsOfKind {
  std::string_view kind;  ///< "4D mesh", "triangle mesh", ...
  std::vector<platform::FileFormat> formats;
};

/// All formats that are read or written, in the order in which they are listed for users.
std::vector<FormatsOfKind> fileFormats();

/// The report of `t4d formats`.
struct FileFormats {
  std::vector<FormatsOfKind> kinds;
};
void describe(Members& members, const FileFormats& all);

}  // namespace t4d::tools
