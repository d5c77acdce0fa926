#include "tools/t4d/mill_tools.h"

#include <utility>

#include <fmt/format.h>

#include "mill/tool_shape.h"
#include "model/number.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

using verbs::MillToolSpec;
using verbs::MillToolSpecs;

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
    if (!verbs::isToolShape(spec)) continue;
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
    if (verbs::isCylinderShape(spec)) {
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

Result<verbs::MillToolSpecs> millToolSpecs(const MillToolOptions& options,
                                           const std::map<int, formats::TableTool>& table) {
  MillToolSpecs specs;
  if (auto added = addTools(options.tools, specs); !added) return added.error();
  verbs::addToolsOfTable(table, specs);
  if (specs.empty()) return invalid("no tool is given; give one, as in --tool ball:d=6,l=30");
  for (const auto& [name, given, member] :
       {std::tuple{"shank", &options.shanks, &MillToolSpec::shank},
        std::tuple{"holder", &options.holders, &MillToolSpec::holder}}) {
    if (auto added = addCylinders(*given, name, member, specs); !added) return added.error();
  }
  return specs;
}

}  // namespace t4d::tools
