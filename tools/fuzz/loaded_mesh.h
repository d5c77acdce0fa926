#pragma once

#include "t4d/formats/triangle_mesh_reader.h"
#include "tools/fuzz/fuzz.h"

namespace t4d::fuzz {

/// A mesh that is read is valid; an error has a message and names a place in `path`.
inline void checkLoaded(const Result<formats::LoadedMesh>& loaded, const std::string& path) {
  if (!loaded) {
    must(!loaded.error().message.empty() && loaded.error().where.starts_with(path),
         "a refusal says what and where");
    return;
  }
  const model::TriangleMesh& mesh = loaded->mesh;
  must(!mesh.triangles.empty(), "a mesh that is accepted has triangles");
  for (const model::Point3& vertex : mesh.vertices) must(vertex.allFinite(), "vertices are finite");
  std::vector<bool> used(mesh.vertices.size());
  for (const model::Triangle& t : mesh.triangles) {
    for (const std::uint32_t corner : t) {
      must(corner < mesh.vertices.size(), "triangles have corners");
      used[corner] = true;
    }
    must(t[0] != t[1] && t[1] != t[2] && t[2] != t[0], "a triangle has three different corners");
  }
  must(std::find(used.begin(), used.end(), false) == used.end(), "every vertex has a triangle");
}

}  // namespace t4d::fuzz
