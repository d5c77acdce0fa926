#include "tools/program/format_list.h"

#include <algorithm>

#include "t4d/formats/animation/foreign_scene.h"
#include "t4d/formats/mesh4d/mesh4d_formats.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/voxel4d/volumes/volume_frames.h"

namespace t4d::tools {
namespace {

constexpr const char* kByExtension = "the extension";

std::vector<std::string> keptBy(const formats::Mesh4dKeeps& keeps) {
  std::vector<std::string> names = {"4D coordinates"};
  const auto add = [&](bool kept, const char* name) {
    if (kept) names.emplace_back(name);
  };
  add(keeps.tetrahedra, "tetrahedra");
  add(keeps.tetrahedra, "orientation");
  add(keeps.doubles, "double precision");
  add(keeps.bodies, "bodies");
  add(keeps.names, "names of bodies");
  add(keeps.attributes != nullptr, "attributes");
  add(keeps.metadata, "metadata");
  return names;
}

void addMeshes4d(std::vector<ListedFormat>& list) {
  list.push_back(
      {"t4d",
       "t4d",
       {".t4d"},
       "4D mesh",
       true,
       true,
       "the signature",
       keptBy({.attributes = [](const model::Attribute&) { return true; }, .metadata = true})});
  list.back().keeps.emplace_back("slabs");
  ListedFormat parts = list.back();
  parts.name = "t4d in parts";
  parts.id.clear();
  parts.extensions = {".t4dm"};
  parts.recognisedBy = kByExtension;
  list.push_back(std::move(parts));
  for (const formats::Mesh4dFormat& format : formats::mesh4dFormats()) {
    list.push_back({std::string(format.name),
                    std::string(format.id),
                    {format.extensions.begin(), format.extensions.end()},
                    "4D mesh",
                    format.keeps.tetrahedra && format.read != nullptr,
                    format.write != nullptr,
                    std::string(format.recognisedBy),
                    keptBy(format.keeps)});
  }
}

void addTriangleMeshes(std::vector<ListedFormat>& list) {
  for (const formats::TriangleMeshFormat& format : formats::triangleMeshFormats()) {
    ListedFormat row{std::string(format.name),
                     {},
                     {std::string(format.extension)},
                     "triangle mesh",
                     format.read != nullptr,
                     format.write != nullptr,
                     kByExtension,
                     {"triangles"}};
    for (const std::string_view kept : format.keeps) row.keeps.emplace_back(kept);
    list.push_back(std::move(row));
  }
}

/// Files of machines, which have any extension.
void addToolPaths(std::vector<ListedFormat>& list) {
  const auto add = [&](const char* name, std::vector<std::string> extensions, const char* option,
                       std::vector<std::string> keeps) {
    list.push_back(
        {name, {}, std::move(extensions), "tool path", true, false, option, std::move(keeps)});
  };
  add("G-code", {".nc", ".ngc", ".gcode", ".tap"}, "the option `--gcode`",
      {"straight moves and chords of arcs", "rapid moves", "changes of tools", "times"});
  add("cutter locations (APT)", {".cl", ".cls", ".apt"}, "the option `--locations`",
      {"straight moves and turns", "rapid moves", "changes of tools", "times"});
  add("tool table of LinuxCNC", {".tbl"}, "the option `--tool-table`",
      {"lengths of tools", "remarks"});
}

void addVolumes(std::vector<ListedFormat>& list) {
  for (const voxel4d::VolumeFormat& format : voxel4d::volumeFormats()) {
    if (list.back().name == format.name) {
      list.back().extensions.emplace_back(format.extension);
      continue;
    }
    list.push_back({std::string(format.name),
                    {},
                    {std::string(format.extension)},
                    "volumes over time",
                    true,
                    false,
                    kByExtension,
                    {format.keeps.begin(), format.keeps.end()}});
  }
}

}  // namespace

std::vector<ListedFormat> formatList() {
  std::vector<ListedFormat> list;
  addMeshes4d(list);
  addTriangleMeshes(list);
  list.push_back({"t4d motion",
                  {},
                  {".json"},
                  "motion",
                  true,
                  false,
                  kByExtension,
                  {"screw motions", "units"}});
  list.push_back({"table of poses",
                  {},
                  {".csv", ".tsv", ".txt"},
                  "motion",
                  true,
                  false,
                  kByExtension,
                  {"screw motions"}});
  addToolPaths(list);
  for (const auto& [name, extension] : {std::pair{"PC2", ".pc2"}, std::pair{"MDD", ".mdd"}}) {
    list.push_back({name,
                    {},
                    {extension},
                    "point cache",
                    true,
                    false,
                    kByExtension,
                    {"vertices of a triangle mesh", "times"}});
  }
  list.push_back({"OpenVDB",
                  {},
                  {".vdb"},
                  "volumes over time",
                  true,
                  true,
                  kByExtension,
                  {"level sets", "densities", "masks"}});
  addVolumes(list);
  list.push_back({"ParaView collection of surfaces",
                  {},
                  {".pvd"},
                  "solid over time",
                  true,
                  true,
                  kByExtension,
                  {"triangles", "times"}});
  list.push_back({"animated glTF",
                  {},
                  {".gltf", ".glb"},
                  "solid over time",
                  true,
                  true,
                  kByExtension,
                  {"triangles", "bodies", "names of bodies", "units"}});
  list.push_back({"animated USD",
                  {},
                  {".usda", ".usdz"},
                  "solid over time",
                  true,
                  true,
                  kByExtension,
                  {"triangles", "bodies", "names of bodies", "attributes", "units"}});
  if (formats::readsForeignScenes()) {
    for (const auto& [name, extension] : {std::pair{"FBX", ".fbx"}, std::pair{"COLLADA", ".dae"}}) {
      list.push_back({name,
                      {},
                      {extension},
                      "solid over time",
                      true,
                      false,
                      kByExtension,
                      {"triangles", "bodies", "names of bodies", "units"}});
    }
  }
  return list;
}

}  // namespace t4d::tools
