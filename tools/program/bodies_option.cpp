#include "tools/program/bodies_option.h"

namespace t4d::tools {

void addBodiesOption(CLI::App& command, std::string& bodies) {
  command
      .add_option("--bodies", bodies,
                  "For .obj files: one body per object (`o`) or group (`g`), not one per file")
      ->type_name("object|group")
      ->check(CLI::IsMember({"object", "group"}));
}

std::optional<formats::BodiesBy> bodiesBy(const std::string& bodies) {
  if (bodies.empty()) return std::nullopt;
  return bodies == "group" ? formats::BodiesBy::Group : formats::BodiesBy::Object;
}

}  // namespace t4d::tools
