#include "tools/verbs/file_formats.h"

#include <initializer_list>

#include <nlohmann/json.hpp>

#include "formats/animation/deformation_reader.h"
#include "formats/animation/mesh_steps.h"
#include "formats/gltf/gltf_animation.h"
#include "formats/mesh4d/mesh4d_formats.h"
#include "formats/motion/motion_formats.h"
#include "formats/t4d/t4d_formats.h"
#include "formats/toolpath/tool_path.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/file.h"
#include "t4d/frames.h"
#include "t4d/motion.h"
#include "tools/verbs/json_text.h"
#include "voxel4d/frame_formats.h"

namespace t4d::verbs {
namespace {

using FormatRows = std::vector<platform::FileFormat>;

FormatRows joinedRows(std::initializer_list<FormatRows> lists) {
  FormatRows all;
  for (const FormatRows& rows : lists) all.insert(all.end(), rows.begin(), rows.end());
  return all;
}

FormatRows rowsOfMeshes4d() {
  FormatRows rows;
  for (const formats::Mesh4dFormat& format : formats::mesh4dFormats()) {
    const formats::Mesh4dKeeps& has = format.keeps;
    std::vector<std::string_view> keeps = {"4D coordinates"};
    if (has.tetrahedra) keeps.insert(keeps.end(), {"tetrahedra", "orientation"});
    if (has.doubles) keeps.emplace_back("double precision");
    if (has.bodies) keeps.emplace_back("bodies");
    if (has.names) keeps.emplace_back("names of bodies");
    if (has.attributes != nullptr) keeps.emplace_back("attributes");
    rows.push_back({format.name, format.extensions, std::move(keeps), format.write != nullptr,
                    format.recognisedBy, has.tetrahedra && format.read != nullptr, format.id});
  }
  return rows;
}

FormatRows rowsOfTriangleMeshes() {
  FormatRows rows;
  for (const formats::TriangleMeshFormat& format : formats::triangleMeshFormats()) {
    std::vector<std::string_view> keeps = {"triangles"};
    keeps.insert(keeps.end(), format.keeps.begin(), format.keeps.end());
    rows.push_back({.name = format.name,
                    .extensions = {format.extension},
                    .keeps = std::move(keeps),
                    .writes = format.write != nullptr,
                    .reads = format.read != nullptr});
  }
  return rows;
}

}  // namespace

std::vector<FormatsOfKind> fileFormats() {
  return {{"4D mesh", joinedRows({formats::t4dFormats(), rowsOfMeshes4d()})},
          {"triangle mesh", rowsOfTriangleMeshes()},
          {"motion", formats::motionFormats()},
          {"tool path", formats::toolPathFormats()},
          {"point cache", formats::pointCacheFormats()},
          {"volumes over time", joinedRows({voxel4d::vdbFormats(), voxel4d::volumeFormats()})},
          {"solid over time",
           joinedRows({formats::collectionFormats(), formats::animatedGltfFormats()})}};
}

std::string jsonOf(std::span<const FormatsOfKind> kinds) {
  auto rows = nlohmann::ordered_json::array();
  for (const auto& [kind, formats] : kinds) {
    for (const platform::FileFormat& format : formats) {
      rows.push_back({{"name", format.name},
                      {"id", format.id},
                      {"extensions", format.extensions},
                      {"kind", kind},
                      {"reads", format.reads},
                      {"writes", format.writes},
                      {"recognised_by", format.recognisedBy},
                      {"keeps", format.keeps}});
    }
  }
  return jsonText({{"formats", rows}});
}

}  // namespace t4d::verbs
