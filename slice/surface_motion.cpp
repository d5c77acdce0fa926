#include "slice/surface_motion.h"

#include "model/cell_normal.h"

namespace t4d::slice {
namespace {

using model::Cell;
using model::Point3;
using model::Point4;
using model::Slab;

double speedOf(const Cell& cell, std::span<const Point4> vertices) {
  // Each is made as long as 1 in some coordinate, so that no product of them is out of range.
  const auto edgeTo = [&](std::size_t i) -> Point4 {
    const Point4 edge = vertices[cell[i]] - vertices[cell[0]];
    return edge / edge.cwiseAbs().maxCoeff();
  };
  const Eigen::Vector4d normal = model::crossProduct(edgeTo(1), edgeTo(2), edgeTo(3));
  const double inSpace = normal.head<3>().norm();
  return inSpace > 0 ? -normal[3] / inSpace : 0;  // without it, the section has no area
}

/// The velocity of each vertex of the slab.
std::vector<Point3> vertexVelocities(const Slab& slab) {
  const model::Connectivity& connectivity = *slab.connectivity;
  std::vector<Point3> of(connectivity.vertexCount);
  for (std::uint32_t i = 0; i < connectivity.lowerCount; ++i) {
    of[i] = of[connectivity.firstUpper() + i] = layerVelocity(slab, i);
  }
  const model::Means& means = connectivity.means;
  for (std::uint32_t mean = 0; mean < means.size(); ++mean) {
    const std::uint32_t begin = means.offsets[mean];
    const std::uint32_t end = means.offsets[mean + 1];
    Point3 sum = Point3::Zero();
    for (std::uint32_t k = begin; k < end; ++k) sum += of[means.sources[k]];
    of[connectivity.firstMean() + mean] = sum / (end - begin);
  }
  return of;
}

}  // namespace

Point3 areaVector(const model::TriangleMesh& mesh, const model::Triangle& triangle) {
  const Point3& corner = mesh.vertices[triangle[0]];
  return (mesh.vertices[triangle[1]] - corner).cross(mesh.vertices[triangle[2]] - corner) / 2;
}

std::vector<double> speedsOf(const Cut& cut, std::span<const Cell> cells,
                             std::span<const Point4> vertices) {
  std::vector<double> speeds;
  speeds.reserve(cut.cells.size());
  for (const std::uint32_t cell : cut.cells) speeds.push_back(speedOf(cells[cell], vertices));
  return speeds;
}

Point3 layerVelocity(const Slab& slab, std::uint32_t i) {
  const Point4 step = slab.upperLayer()[i] - slab.lowerLayer()[i];
  return step.head<3>() / step[3];
}

std::vector<Point3> velocitiesOf(const Cut& cut, std::span<const double> fractions,
                                 const Slab& slab) {
  const std::vector<Point3> ofVertices = vertexVelocities(slab);
  std::vector<Point3> velocities;
  velocities.reserve(cut.points.size());
  for (std::size_t i = 0; i < cut.points.size(); ++i) {
    const Point3& below = ofVertices[cut.points[i].below];
    const Point3& above = ofVertices[cut.points[i].above];
    velocities.emplace_back(below + fractions[i] * (above - below));
  }
  return velocities;
}

}  // namespace t4d::slice
