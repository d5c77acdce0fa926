#include "tools/program/input_bodies.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/model/units.h"

namespace t4d::tools {

Result<InputBodies> openBodies(const std::string& path, const std::string& bodyName) {
  auto reader = formats::T4dReader::open(path);
  if (!reader) return pass(reader.error());
  InputBodies input{std::move(*reader), {}};
  const std::vector<formats::BodyInfo>& infos = input.reader.metadata().bodies;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    names.push_back(infos[i].name);
    if (bodyName.empty() || names[i] == bodyName) {
      input.bodies.push_back({names[i], &input.reader.body(i)});
    }
  }
  if (input.bodies.empty()) {
    return invalid(fmt::format("has no body '{}'; it has {}", bodyName, fmt::join(names, ", ")),
                   path);
  }
  return input;
}

model::Bounds3 boundsOf(const InputBodies& input) {
  const std::vector<formats::BodyInfo>& infos = input.reader.metadata().bodies;
  model::Bounds3 bounds;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    const bool selected = std::ranges::any_of(
        input.bodies, [&](const model::Body& body) { return body.name == infos[i].name; });
    if (selected) bounds.add(input.reader.summary(i).bounds);
  }
  return bounds;
}

void addBodyOption(CLI::App& command, std::string& bodyName) {
  command.add_option("--body", bodyName, "Use only the body with this name (default: all)");
}

formats::GltfPlacement placementOf(const formats::Metadata& metadata,
                                   std::vector<std::string>& notices) {
  formats::GltfPlacement placement;
  placement.zUp = metadata.up == "z";
  if (!metadata.lengthUnit.empty()) {
    if (const auto metres = model::metresPer(metadata.lengthUnit)) {
      placement.metresPerUnit = *metres;
    } else {
      notices.push_back(
          fmt::format("the length unit '{}' is unknown; it is written to glTF as a metre",
                      metadata.lengthUnit));
    }
  }
  nlohmann::ordered_json extras;
  if (!metadata.lengthUnit.empty()) extras["length_unit"] = metadata.lengthUnit;
  if (!metadata.timeUnit.empty()) extras["time_unit"] = metadata.timeUnit;
  if (!extras.empty()) placement.extras = extras.dump();
  return placement;
}

}  // namespace t4d::tools
