#include <utility>

#include "t4d/weave.h"

namespace t4d::voxel4d {

SolidAtTime movingSolid(model::TriangleMesh mesh, model::Motion motion) {
  return [mesh = std::move(mesh), motion = std::move(motion)](double time) {
    const model::Pose pose = motion.at(time);
    model::TriangleMesh posed;
    posed.triangles = mesh.triangles;
    posed.vertices.reserve(mesh.vertices.size());
    for (const model::Point3& vertex : mesh.vertices) posed.vertices.push_back(pose(vertex));
    return Result<model::TriangleMesh>(std::move(posed));
  };
}

}  // namespace t4d::voxel4d
