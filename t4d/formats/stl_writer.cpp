#include "t4d/formats/stl_writer.h"

#include <cstring>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "t4d/formats/written_mesh.h"

namespace t4d::formats {
namespace {

/// The header must not begin with "solid", as text files do.
constexpr char kHeader[80] = "binary STL, written by t4d";

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
  if (auto done = file.write(kHeader, sizeof(kHeader)); !done) return pass(done.error());
  if (auto done = file.write(&count32, sizeof(count32)); !done) return pass(done.error());
  for (const NamedMesh& named : meshes) {
    const auto vertices = roundedVertices(named);
    if (!vertices) return pass(vertices.error());
    for (const auto& [a, b, c] : named.mesh.triangles) {
      const auto& v = named.mesh.vertices;
      const Eigen::Vector3d normal = (v[b] - v[a]).cross(v[c] - v[a]).stableNormalized();
      Eigen::Matrix<float, 3, 4> numbers;
      numbers << normal.cast<float>(), (*vertices)[a], (*vertices)[b], (*vertices)[c];
      std::array<char, 50> record{};
      std::memcpy(record.data(), numbers.data(), numbers.size() * sizeof(float));
      if (auto done = file.write(record.data(), record.size()); !done) return pass(done.error());
    }
  }
  return options.attributes ? allAttributesLost(meshes, "STL has no room for attributes")
                            : std::vector<std::string>{};
}

}  // namespace t4d::formats
