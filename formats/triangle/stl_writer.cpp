#include "formats/triangle/stl_writer.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "formats/triangle/written_mesh.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kStlHeaderBytes = 80;

/// Must not begin with "solid", as text files do.
std::string headerOf(const MeshWriteOptions& options) {
  std::string header = "binary STL, written by t4d";
  const std::string origin = originComment(options);
  if (!origin.empty()) header = origin + ", written by t4d";
  header.resize(kStlHeaderBytes);
  return header;
}

}  // namespace

Result<std::vector<std::string>> writeStl(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  std::uint64_t count = 0;
  for (const NamedMesh& named : meshes) count += named.mesh.triangles.size();
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("{} triangles are more than an STL file can count", count));
  }
  const auto count32 = static_cast<std::uint32_t>(count);
  const std::string header = headerOf(options);
  if (auto done = file.write(header.data(), header.size()); !done) return done.error();
  if (auto done = file.write(&count32, sizeof(count32)); !done) return done.error();
  RoundingLoss rounding;
  for (const NamedMesh& named : meshes) {
    const auto vertices = roundedVertices(named, options.center, rounding);
    if (!vertices) return vertices.error();
    for (const auto& [a, b, c] : named.mesh.triangles) {
      const auto& v = named.mesh.vertices;
      const Eigen::Vector3d normal = (v[b] - v[a]).cross(v[c] - v[a]).stableNormalized();
      Eigen::Matrix<float, 3, 4> numbers;
      numbers << normal.cast<float>(), (*vertices)[a], (*vertices)[b], (*vertices)[c];
      std::array<char, 50> record{};
      std::memcpy(record.data(), numbers.data(), numbers.size() * sizeof(float));
      if (auto done = file.write(record.data(), record.size()); !done) return done.error();
    }
  }
  std::vector<std::string> lost;
  if (options.attributes) lost = allAttributesLost(meshes, "STL has no room for attributes");
  if (options.normals && !options.normals->flat) {
    lost.emplace_back("normals of vertices: STL has one for each triangle");
  }
  if (hasColors(meshes, model::Domain::Vertex, model::Domain::Vertex) ||
      hasColors(meshes, model::Domain::Cell, model::Domain::Vertex)) {
    lost.emplace_back("colours: STL has none");
  }
  if (auto line = rounding.line()) lost.push_back(std::move(*line));
  return lost;
}

}  // namespace t4d::formats
