#include "tools/verbs/mill_tools.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "mill/tool_shape.h"
#include "tools/verbs/solid_input.h"

namespace t4d::verbs {
namespace {

bool isToolFile(const std::string& text) {
  std::error_code ignored;
  return std::filesystem::exists(text, ignored);
}

Result<model::TriangleMesh> readToolMesh(const std::string& path, std::vector<std::string>& losses,
                                         Observer& observer) {
  auto loaded = readSolidInput({path}, observer);
  if (!loaded) return loaded.error();
  losses.insert(losses.end(), loaded->losses.begin(), loaded->losses.end());
  return std::move(loaded->bodies.front().mesh);
}

Result<model::TriangleMesh> meshOfTool(const std::string& spec, double tolerance,
                                       std::vector<std::string>& losses, Observer& observer) {
  if (!isToolShape(spec)) return readToolMesh(spec, losses, observer);
  const auto shape = mill::parseTool(spec);
  if (!shape) return invalid(shape.error().message, "the tool table");
  auto mesh = mill::toolMesh(*shape, tolerance);
  if (!mesh) mesh.error().where = spec;
  return mesh;
}

/// That of a shank or a holder, which begins at the height `from` if it is a cylinder.
Result<model::TriangleMesh> meshOfGuard(const std::string& spec, double from, double tolerance,
                                        std::vector<std::string>& losses, Observer& observer) {
  if (!isCylinderShape(spec)) return readToolMesh(spec, losses, observer);
  const auto cylinder = mill::parseCylinder(spec);
  if (!cylinder) return cylinder.error();
  auto mesh = mill::cylinderMesh(*cylinder, from, tolerance);
  if (!mesh) mesh.error().where = spec;
  return mesh;
}

}  // namespace

std::vector<std::string> MillToolSpec::files() const {
  std::vector<std::string> found;
  if (!isToolShape(tool)) found.push_back(tool);
  for (const std::string& guard : {shank, holder}) {
    if (!guard.empty() && !isCylinderShape(guard)) found.push_back(guard);
  }
  return found;
}

bool isToolShape(const std::string& text) {
  if (mill::namesToolKind(text)) return true;
  const auto colon = text.find(':');
  return colon != text.npos && text.find('=', colon) != text.npos && !isToolFile(text);
}

bool isCylinderShape(const std::string& text) {
  return text.find('=') != text.npos && !isToolFile(text);
}

void addToolsOfTable(const std::map<int, formats::TableTool>& table, MillToolSpecs& specs) {
  if (specs.contains(0)) return;
  for (const auto& [number, tool] : table) {
    const std::string spec = tool.remark.substr(0, tool.remark.find_first_of(" \t"));
    if (number > 0 && mill::namesToolKind(spec)) specs.emplace(number, MillToolSpec{spec});
  }
}

Result<std::vector<mill::Tool>> readMillTools(const MillToolSpecs& specs, double tolerance,
                                              std::vector<std::string>& losses,
                                              Observer& observer) {
  std::vector<mill::Tool> tools;
  for (const auto& [number, spec] : specs) {
    mill::Tool tool{.number = number};
    auto mesh = meshOfTool(spec.tool, tolerance, losses, observer);
    if (!mesh) return mesh.error();
    tool.mesh = std::move(*mesh);
    double top = model::boundsOf(tool.mesh).max.z();
    for (const auto& [name, guard] : {std::pair{"shank", &spec.shank}, {"holder", &spec.holder}}) {
      if (guard->empty()) continue;
      auto held = meshOfGuard(*guard, top, tolerance, losses, observer);
      if (!held) return held.error();
      top = std::max(top, model::boundsOf(*held).max.z());
      tool.guards.push_back({name, std::move(*held)});
    }
    tools.push_back(std::move(tool));
  }
  return tools;
}

std::optional<std::string> givenAs(std::string_view part, const MillToolSpecs& specs) {
  for (const auto& [number, spec] : specs) {
    if (part == mill::partOfTool("tool", number)) return spec.tool;
    if (part == mill::partOfTool("shank", number)) return spec.shank;
    if (part == mill::partOfTool("holder", number)) return spec.holder;
  }
  return std::nullopt;
}

}  // namespace t4d::verbs
