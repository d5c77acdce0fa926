#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/url.h"
#include "t4d/verbs/json_text.h"
#include "t4d/verbs/validate.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/hints.h"
#include "tools/program/input_options.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

ordered_json jsonOf(const verbs::Validation& validation, bool deep) {
  ordered_json value;
  value["valid"] = validation.valid();
  const auto measure = [&](const char* key, auto member) {
    value[key] = validation.mesh ? ordered_json((*validation.mesh).*member) : ordered_json();
  };
  measure("closed", &measure::MeshReport::closed);
  measure("oriented", &measure::MeshReport::oriented);
  measure("hypervolume", &measure::MeshReport::hypervolume);
  measure("boundary_volume", &measure::MeshReport::boundaryVolume);
  measure("components", &measure::MeshReport::components);
  measure("degenerate_cells", &measure::MeshReport::degenerateCells);
  if (deep) {
    value["vertex_links_ok"] =
        validation.mesh ? verbs::orNull(validation.mesh->vertexLinksOk) : ordered_json();
  }
  ordered_json messages = ordered_json::array();
  for (const measure::Issue& issue : validation.issues.issues) {
    messages.push_back({{"code", issue.code},
                        {"severity", static_cast<int>(issue.severity)},
                        {"message", issue.message},
                        {"slab", verbs::orNull(issue.slab)},
                        {"offset", verbs::orNull(issue.offset)}});
  }
  value["issues"] = {{"errors", validation.issues.errors},
                     {"warnings", validation.issues.warnings},
                     {"messages", messages}};
  return value;
}

void printText(const std::string& path, const verbs::Validation& validation) {
  print("{}: {}\n", path, validation.valid() ? "valid" : "INVALID");
  if (validation.mesh) {
    const measure::MeshReport& mesh = *validation.mesh;
    const auto yes = [](bool value) { return value ? "yes" : "NO"; };
    print("  closed {}, oriented {}", yes(mesh.closed), yes(mesh.oriented));
    if (mesh.vertexLinksOk) print(", vertex links are spheres {}", yes(*mesh.vertexLinksOk));
    print("\n  {}, {} in {}, {}\n", counted(mesh.vertices, "vertex", "vertices"),
          counted(mesh.tetrahedra, "tetrahedron", "tetrahedra"), counted(mesh.slabs, "slab"),
          counted(mesh.components, "component"));
    print("  hypervolume {:.12g}, 3-volume of the boundary {:.12g}, {}\n", mesh.hypervolume,
          mesh.boundaryVolume, counted(mesh.degenerateCells, "degenerate cell"));
  }
  for (const measure::Issue& issue : validation.issues.issues) {
    static constexpr const char* kNames[] = {"error", "warning", "information", "hint"};
    std::string where;
    if (issue.slab) where += fmt::format(" slab {}", *issue.slab);
    if (issue.offset) where += fmt::format(" at byte {}", *issue.offset);
    print("  {}{}: {} [{}]\n", kNames[static_cast<int>(issue.severity)], where, issue.message,
          issue.code);
  }
}

int run(const std::string& path, bool deep, bool json, std::optional<std::uint64_t> maxCells) {
  Result<verbs::Validation> validation;
  {
    ProgressBar bar("validating");
    validation = verbs::validate(path, {.vertexLinks = deep}, bar.callback(), maxCells);
  }
  if (!validation) return report(validation.error());
  if (json) {
    printJson(jsonOf(*validation, deep));
  } else {
    printText(path == "-" ? "standard input" : formats::shownName(path), *validation);
  }
  // A file that can be read to its end needs no recovery.
  if (!validation->mesh) sayHint(hintForFile(path));
  return validation->valid() ? kDone : kInvalid;
}

}  // namespace

void addValidate(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "validate", "Check every byte of a .t4d file, and that its mesh is closed and oriented");
  auto path = std::make_shared<std::string>();
  auto deep = std::make_shared<bool>(false);
  auto json = std::make_shared<bool>(false);
  auto maxCells = std::make_shared<std::optional<std::uint64_t>>();
  command->add_option("FILE", *path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  command->add_flag("--deep", *deep, "Also check that every vertex link is a sphere");
  command->add_flag("--json", *json, "Print JSON");
  addMaxCellsOption(*command, *maxCells);
  command->footer("Examples:\n  t4d validate bolt.t4d --deep\n  zcat bolt.t4d.gz | t4d validate -");
  command->callback([=, &exitCode] { exitCode = run(*path, *deep, *json, *maxCells); });
}

}  // namespace t4d::tools
