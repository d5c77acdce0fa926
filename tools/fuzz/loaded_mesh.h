#pragma once

#include "formats/gltf/gltf_animation.h"
#include "t4d/surface.h"
#include "tools/fuzz/fuzz.h"

namespace t4d::fuzz {

/// A tolerance of animations so large that few keys are made.
inline constexpr double kFewKeys = 1e30;

/// A mesh that is read is valid; an error has a message and names a place in `path`.
inline void checkLoaded(const Result<formats::LoadedMesh>& loaded, const std::string& path) {
  if (!loaded) {
    must(!loaded.error().message.empty() && loaded.error().where.file.starts_with(path),
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

/// Bodies of an animation have names, and keys that go forward; an error has a message and names a
/// place in `path`.
inline void checkAnimation(const Result<formats::AnimatedScene>& scene, const std::string& path) {
  if (!scene) {
    must(!scene.error().message.empty() && scene.error().where.file.starts_with(path),
         "a refusal says what and where");
    return;
  }
  must(!scene->bodies.empty(), "a scene has bodies");
  for (const auto& body : scene->bodies) {
    must(!body.name.empty() && !body.runs.empty(), "a body has a name and a run");
    std::vector<model::Point3> last(body.mesh.vertices.size());
    for (const auto& run : body.runs) {
      must(run->count() >= 2, "a run lasts");
      for (std::uint64_t key = 1; key < run->count(); ++key) {
        must(run->time(key) > run->time(key - 1), "keys go forward");
      }
      must(run->positions(run->count() - 1, last).has_value(), "samples were checked");
    }
  }
}

}  // namespace t4d::fuzz
