#include "tools/t4d/bodies_option.h"

#include <vector>

#include <fmt/format.h>

namespace t4d::tools {

void addBodiesOption(CLI::App& command, std::string& bodies, bool components) {
  std::vector<std::string> values = {"object", "group"};
  std::string text = "For .obj files: one body per object (`o`) or group (`g`), not one per file";
  if (components) {
    values.emplace_back(kComponents);
    text += "; for animations and deformations: one per connected component";
  }
  command.add_option("--bodies", bodies, text)
      ->type_name(fmt::format("{}", fmt::join(values, "|")))
      ->check(CLI::IsMember(values));
}

std::optional<formats::BodiesBy> bodiesBy(const std::string& bodies) {
  if (bodies.empty() || bodies == kComponents) return std::nullopt;
  return bodies == "group" ? formats::BodiesBy::Group : formats::BodiesBy::Object;
}

}  // namespace t4d::tools
