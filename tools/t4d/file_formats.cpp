#include "tools/t4d/file_formats.h"

#include <initializer_list>

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
#include "tools/t4d/members.h"
#include "voxel4d/frame_formats.h"

namespace t4d::tools {
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

void describe(Members& members, const FileFormats& all) {
  struct Row {
    std::string_view kind;
    platform::FileFormat format;
  };
  std::vector<Row> rows;
  for (const auto& [kind, formats] : all.kinds) {
    for (const platform::FileFormat& format : formats) rows.push_back({kind, format});
  }
  members(
      "formats", rows, "In the order of the tables, 4D meshes first.",
      [](Members& own, const Row& row) {
        const platform::FileFormat& format = row.format;
        own("name", format.name, "For users.").notEmpty();
        own("id", format.id, "As `t4d convert --from` and `--to` take it; empty if they do not.");
        own("extensions", format.extensions, "With their dots, in lower case.").itemsFrom(1);
        own("kind", row.kind, "What it holds: 4D mesh, triangle mesh, ...").notEmpty();
        own("reads", format.reads, "Files of this format are read.");
        own("writes", format.writes, "Files of this format are written.");
        own("recognised_by", format.recognisedBy, "How a file shows that it has this format.")
            .notEmpty();
        own("keeps", format.keeps, "What it holds of what t4d knows; converting loses the rest.");
      });
}

}  // namespace t4d::tools
