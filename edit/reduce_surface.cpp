#include "edit/reduce_surface.h"

#include <cassert>
#include <limits>

#include "edit/mend_steps.h"

#if T4D_WITH_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace t4d::edit {

#if T4D_WITH_MESHOPTIMIZER

bool reducesSurfaces() { return true; }

ReducedSurface reducedSurface(const model::TriangleMesh& mesh, std::size_t triangles) {
  const model::Bounds3 bounds = model::boundsOf(mesh);
  const model::Point3 center = (bounds.min + bounds.max) / 2;
  const double size = (bounds.max - bounds.min).maxCoeff();
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(mesh.vertices.size());
  for (const model::Point3& vertex : mesh.vertices) {
    positions.emplace_back(((vertex - center) / size).cast<float>());
  }
  const unsigned int* indices = mesh.triangles.front().data();
  const std::size_t count = 3 * mesh.triangles.size();
  model::TriangleMesh reduced;
  reduced.vertices = mesh.vertices;
  reduced.triangles.resize(mesh.triangles.size());
  float error = 0;
  const std::size_t left = meshopt_simplify(
      reduced.triangles.front().data(), indices, count, positions.front().data(), positions.size(),
      sizeof(Eigen::Vector3f), 3 * triangles, std::numeric_limits<float>::max(), 0, &error);
  reduced.triangles.resize(left / 3);
  dropUnusedVertices(reduced);
  const float scale =
      meshopt_simplifyScale(positions.front().data(), positions.size(), sizeof(Eigen::Vector3f));
  return {std::move(reduced), static_cast<double>(error * scale) * size};
}

#else

bool reducesSurfaces() { return false; }

ReducedSurface reducedSurface(const model::TriangleMesh& mesh, std::size_t /*triangles*/) {
  return {mesh};
}

#endif

}  // namespace t4d::edit
