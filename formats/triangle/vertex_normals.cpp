#include "formats/triangle/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "model/surface_edges.h"
#include "model/union_find.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

using model::Point3;
using model::Triangle;

/// An edge with more triangles is no place for shading: each is compared with the next one only.
constexpr std::size_t kMostAtEdge = 8;

/// Unites the corners at both ends of edges whose triangles share their normals.
class CornerGroups {
 public:
  CornerGroups(const model::TriangleMesh& mesh, const std::vector<Point3>& normals,
               double creaseDegrees)
      : mesh_(mesh),
        normals_(normals),
        all_(creaseDegrees >= 180),
        least_(std::cos(creaseDegrees * std::numbers::pi / 180)),
        groups_(3 * mesh.triangles.size()) {
    const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
    for (const auto& [low, high, begin, end] : edges.edges) {
      const std::uint32_t reach = end - begin > kMostAtEdge ? 1 : end - begin;
      for (std::uint32_t i = begin; i < end; ++i) {
        for (std::uint32_t j = i + 1; j < std::min(end, i + 1 + reach); ++j) {
          join(edges.sides[i], edges.sides[j]);
        }
      }
    }
  }

  /// The first corner of those that share a normal.
  std::uint32_t of(std::uint32_t corner) { return groups_.root(corner); }

 private:
  void join(std::uint32_t a, std::uint32_t b) {
    if (!all_ && normals_[a / 3].dot(normals_[b / 3]) < least_) return;
    uniteCorners(groups_, mesh_, a, b);
  }

  const model::TriangleMesh& mesh_;
  const std::vector<Point3>& normals_;
  bool all_;
  double least_;  // cosine between normals that are shared
  model::UnionFind groups_;
};

double angleAt(const model::TriangleMesh& mesh, const Triangle& triangle, std::uint32_t corner) {
  const Point3& at = mesh.vertices[triangle[corner]];
  const Point3 a = (mesh.vertices[triangle[(corner + 1) % 3]] - at).stableNormalized();
  const Point3 b = (mesh.vertices[triangle[(corner + 2) % 3]] - at).stableNormalized();
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// The normal has length 1, or 0 for a flat triangle.
std::vector<Point3> faceNormalsOf(const model::TriangleMesh& mesh) {
  std::vector<Point3> faces;
  faces.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices;
    // Edges of length 1 at most, so that products stay in range.
    const double size =
        std::max((v[b] - v[a]).cwiseAbs().maxCoeff(), (v[c] - v[a]).cwiseAbs().maxCoeff());
    const Point3 normal = ((v[b] - v[a]) / size).cross((v[c] - v[a]) / size);
    faces.push_back(size > 0 ? normal.stableNormalized() : Point3(Point3::Zero()));
  }
  return faces;
}

std::vector<Eigen::Vector3f> meansOf(const std::vector<Point3>& faces,
                                     const VerticesWithNormals& layout,
                                     const model::TriangleMesh& mesh) {
  std::vector<Point3> sums(layout.sources.size(), Point3(Point3::Zero()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      sums[layout.triangles[i][corner]] += angleAt(mesh, mesh.triangles[i], corner) * faces[i];
    }
  }
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(sums.size());
  for (const Point3& sum : sums) {
    const double length = sum.norm();
    normals.push_back(length > 0 ? Eigen::Vector3f((sum / length).cast<float>())
                                 : Eigen::Vector3f(Eigen::Vector3f::UnitZ()));
  }
  return normals;
}

}  // namespace

VerticesWithNormals withNormals(const model::TriangleMesh& mesh, const NormalStyle& style) {
  const std::vector<Point3> faces = faceNormalsOf(mesh);
  VerticesWithNormals made;
  std::vector<std::uint32_t> numberOf(3 * mesh.triangles.size());
  CornerGroups groups(mesh, faces, style.creaseDegrees);
  for (std::uint32_t corner = 0; corner < numberOf.size(); ++corner) {
    const Triangle& triangle = mesh.triangles[corner / 3];
    const std::uint32_t first = style.flat ? corner : groups.of(corner);
    if (first == corner) {
      numberOf[corner] = static_cast<std::uint32_t>(made.sources.size());
      made.sources.push_back(triangle[corner % 3]);
    }
    numberOf[corner] = numberOf[first];
    if (corner % 3 == 0) made.triangles.emplace_back();
    made.triangles.back()[corner % 3] = numberOf[corner];
  }
  made.normals = meansOf(faces, made, mesh);
  return made;
}

std::vector<Eigen::Vector3f> normalsWhenMoved(const VerticesWithNormals& layout,
                                              const model::TriangleMesh& mesh) {
  return meansOf(faceNormalsOf(mesh), layout, mesh);
}

VerticesWithNormals withoutNormals(const model::TriangleMesh& mesh) {
  VerticesWithNormals made;
  made.sources.resize(mesh.vertices.size());
  std::iota(made.sources.begin(), made.sources.end(), 0U);
  made.triangles = mesh.triangles;
  return made;
}

}  // namespace t4d::formats
