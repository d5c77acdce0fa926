#pragma once

#include <string>

namespace t4d::tools {

/// A name as a field of a table, in quotes if it needs them (RFC 4180).
inline std::string csvField(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string field = "\"";
  for (const char c : name) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

}  // namespace t4d::tools
