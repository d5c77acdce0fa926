#include "tools/t4d/material_names.h"

#include <nlohmann/json.hpp>

namespace t4d::tools {

std::vector<std::string> materialNamesOf(const formats::Metadata& metadata) {
  const auto details = nlohmann::json::parse(metadata.detailsJson, nullptr, false);
  if (!details.is_object()) return {};
  const auto names = details.find("materials");
  if (names == details.end() || !names->is_array()) return {};
  std::vector<std::string> read;
  for (const auto& name : *names) {
    if (!name.is_string()) return {};
    read.push_back(name.get<std::string>());
  }
  return read;
}

}  // namespace t4d::tools
