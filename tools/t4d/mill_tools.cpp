#include "tools/t4d/mill_tools.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "mill/tool_shape.h"
#include "model/number.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/solid_input.h"

namespace t4d::tools {
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

namespace {

/// "2=flat:d=6,l=30" as 2 and the rest, and 0 where there is no number.
std::pair<int, std::string> numbered(const std::string& text) {
  std::string_view rest = text;
  const auto number = model::takeNumber<int>(rest);
  if (!number || *number <= 0 || !rest.starts_with('=')) return {0, text};
  return {*number, std::string(rest.substr(1))};
}

Result<void> addTools(const std::vector<std::string>& given, MillToolSpecs& specs) {
  for (const std::string& text : given) {
    const auto [number, spec] = numbered(text);
    if (!specs.emplace(number, MillToolSpec{spec}).second) {
      return invalid(number == 0
                         ? std::string("--tool is given twice; number the tools, as in --tool "
                                       "1=flat:d=6,l=30")
                         : fmt::format("--tool {}= is given twice", number));
    }
    if (specs.size() > 1 && specs.contains(0)) {
      return invalid("--tool is given with and without a number; number all tools, or none");
    }
    if (!isToolShape(spec)) continue;
    if (const auto shape = mill::parseTool(spec); !shape) {
      return invalid("--tool: " + shape.error().message);
    }
  }
  return {};
}

/// Those without a number are of all tools that have no other.
Result<void> addCylinders(const std::vector<std::string>& given, const std::string& name,
                          std::string MillToolSpec::*member, MillToolSpecs& specs) {
  std::string ofAll;
  for (const std::string& text : given) {
    const auto [number, spec] = numbered(text);
    if (isCylinderShape(spec)) {
      if (const auto cylinder = mill::parseCylinder(spec); !cylinder) {
        return invalid(fmt::format("--{}: {}", name, cylinder.error().message));
      }
    }
    const auto of = specs.find(number);
    if (number != 0 && of == specs.end()) {
      return invalid(
          fmt::format("--{} {}= is given, and there is no tool {}", name, number, number));
    }
    std::string& into = number == 0 ? ofAll : of->second.*member;
    if (!into.empty()) return invalid(fmt::format("--{} is given twice for a tool", name));
    into = spec;
  }
  for (auto& [number, spec] : specs) {
    if ((spec.*member).empty()) spec.*member = ofAll;
  }
  return {};
}

}  // namespace

void MillToolOptions::addTo(CLI::App& command) {
  command
      .add_option(
          "--tool", tools,
          "Tool: ball:d=6,l=30, flat:, bull:, drill:, vbit:, chamfer:, taper: or a triangle "
          "mesh; N=SPEC for tool N (repeatable)")
      ->check(someName())
      ->allow_extra_args(false);
  command
      .add_option("--shank", shanks,
                  "Shank above the tool: d=6,l=40 (a cylinder) or a triangle mesh; N=SPEC for tool "
                  "N")
      ->check(someName())
      ->allow_extra_args(false);
  command
      .add_option("--holder", holders,
                  "Holder above the shank: d=40,l=50 (a cylinder) or a triangle mesh; N=SPEC for "
                  "tool N")
      ->check(someName())
      ->allow_extra_args(false);
}

Result<MillToolSpecs> millToolSpecs(const MillToolOptions& options,
                                    const std::map<int, formats::TableTool>& table) {
  MillToolSpecs specs;
  if (auto added = addTools(options.tools, specs); !added) return added.error();
  addToolsOfTable(table, specs);
  if (specs.empty()) return invalid("no tool is given; give one, as in --tool ball:d=6,l=30");
  for (const auto& [name, given, member] :
       {std::tuple{"shank", &options.shanks, &MillToolSpec::shank},
        std::tuple{"holder", &options.holders, &MillToolSpec::holder}}) {
    if (auto added = addCylinders(*given, name, member, specs); !added) return added.error();
  }
  return specs;
}

}  // namespace t4d::tools
