#include "tools/program/input_bodies.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/model/units.h"
#include "tools/program/option_checks.h"
#include "tools/program/similar_words.h"
#include "tools/program/version.h"

namespace t4d::tools {

std::uint64_t slabCountOf(std::span<const model::Body> bodies) {
  std::uint64_t count = 0;
  for (const model::Body& body : bodies) count += body.source->slabCount();
  return count;
}

Result<InputBodies> openBodies(const std::string& path, const InputOptions& options) {
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, options.maxCells);
  if (!reader) return pass(reader.error());
  InputBodies input{std::move(*reader), {}};
  const std::vector<formats::BodyInfo>& infos = input.reader.metadata().bodies;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    names.push_back(infos[i].name);
    if (options.bodies.empty() || std::ranges::count(options.bodies, names[i]) > 0) {
      input.bodies.push_back({names[i], &input.reader.body(i)});
    }
  }
  for (const std::string& wanted : options.bodies) {
    if (std::ranges::count(names, wanted) > 0) continue;
    return invalid(fmt::format("has no body '{}'{}; it has {}", wanted, didYouMean(wanted, names),
                               fmt::join(names, ", ")),
                   input.reader.name());
  }
  return input;
}

bool followsPoses(const InputBodies& input) {
  const auto details = nlohmann::json::parse(input.reader.metadata().detailsJson);
  const auto source = details.find("source");
  return source == details.end() || !source->is_object() || !source->contains("mesh") ||
         source->contains("motion");
}

formats::Metadata metadataOf(const InputBodies& input) {
  formats::Metadata metadata = input.reader.metadata();
  metadata.generator = std::string(versionText());
  const auto isSelected = [&](const std::string& name) {
    return std::ranges::any_of(input.bodies,
                               [&](const model::Body& body) { return body.name == name; });
  };
  std::erase_if(metadata.bodies,
                [&](const formats::BodyInfo& body) { return !isSelected(body.name); });
  for (formats::BodyInfo& body : metadata.bodies) {
    if (!isSelected(body.parent)) body.parent.clear();
  }
  return metadata;
}

Error inInput(Error error, const InputBodies& input) {
  if (error.where.empty()) error.where = input.reader.name();
  return error;
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

void InputOptions::addTo(CLI::App& command) {
  command.add_option("--body", bodies, "Use only this body; repeatable (default: all)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(someName());
  addMaxCellsOption(command, maxCells);
}

void addMaxCellsOption(CLI::App& command, std::optional<std::uint64_t>& maxCells) {
  command
      .add_option("--max-cells", maxCells,
                  "Maximum number of cells to accept (default: see docs/limits.md)")
      ->type_name("N");
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
