#include "formats/t4d/url.h"

#include <algorithm>

namespace t4d::formats {

std::string schemeOf(std::string_view text) {
  const std::size_t end = text.find("://");
  if (end == text.npos || end == 0) return {};
  std::string scheme(text.substr(0, end));
  for (char& c : scheme) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool letter = c >= 'a' && c <= 'z';
    const bool other = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    if (!letter && !(other && &c != scheme.data())) return {};
  }
  return scheme;
}

std::string shownName(std::string_view pathOrUrl) {
  const std::string scheme = schemeOf(pathOrUrl);
  if (scheme.empty()) return std::string(pathOrUrl);
  constexpr std::string_view kAfterScheme = "://";
  std::string_view rest = pathOrUrl.substr(scheme.size() + kAfterScheme.size());
  rest = rest.substr(0, rest.find_first_of("?#"));
  const std::size_t user = rest.substr(0, rest.find('/')).rfind('@');
  if (user != rest.npos) rest.remove_prefix(user + 1);
  return scheme + std::string(kAfterScheme) + std::string(rest);
}

}  // namespace t4d::formats
