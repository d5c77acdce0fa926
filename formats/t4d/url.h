#pragma once

#include <string>
#include <string_view>

namespace t4d::formats {

/// The scheme of a URL such as "https://host/file", in lower case; empty for the path of a file.
std::string schemeOf(std::string_view text);

/// What messages call a file: its path as it is, a URL without user, password, query and fragment,
/// which may hold secrets.
std::string shownName(std::string_view pathOrUrl);

}  // namespace t4d::formats
