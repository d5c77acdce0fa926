#include "formats/triangle/obj_writer.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "formats/triangle/vertex_normals.h"
#include "formats/triangle/written_mesh.h"
#include "model/corner_attributes.h"

namespace t4d::formats {
namespace {

const std::string kNoMaterial;

/// A name must be on one line.
std::string onOneLine(std::string name) {
  for (char& c : name) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return name;
}

/// Whether an attribute has the texture coordinates of all vertices, or of all corners.
bool isUv(const model::Attribute& attribute, const model::TriangleMesh& mesh) {
  const bool ofCorners = attribute.name == "uv" + std::string(model::kCornersOf);
  const bool isNamed = ofCorners
                           ? attribute.domain == model::Domain::Cell
                           : attribute.name == "uv" && attribute.domain == model::Domain::Vertex;
  if (!isNamed || attribute.components != (ofCorners ? 6 : 2) || !fits(attribute, mesh)) {
    return false;
  }
  for (std::size_t row = 0; row < attribute.rows(); ++row) {
    for (std::uint32_t i = 0; i < attribute.components; ++i) {
      if (!std::isfinite(attributeNumber(attribute, row, i))) return false;
    }
  }
  return true;
}

/// The texture coordinates of a mesh; null if it has none.
const model::Attribute* uvOf(const model::TriangleMesh& mesh) {
  const auto found = std::ranges::find_if(
      mesh.attributes, [&](const model::Attribute& attribute) { return isUv(attribute, mesh); });
  return found == mesh.attributes.end() ? nullptr : &*found;
}

/// The number of the texture coordinates of a corner, from 0.
std::uint64_t uvNumber(const model::Attribute& uv, const model::TriangleMesh& mesh,
                       std::size_t triangle, std::size_t corner) {
  return uv.domain == model::Domain::Vertex ? mesh.triangles[triangle][corner]
                                            : 3 * triangle + corner;
}

/// The colours of a mesh that are written as they are: three bytes for each vertex. Null if it has
/// none, or others are written.
const model::Attribute* colorsOf(const NamedMesh& named) {
  if (named.color || named.colors) return nullptr;
  const auto found = std::ranges::find_if(named.mesh.attributes, [&](const auto& attribute) {
    return attribute.name == "color" && attribute.domain == model::Domain::Vertex &&
           attribute.type == model::ScalarType::UInt8 && attribute.components == 3 &&
           fits(attribute, named.mesh);
  });
  return found == named.mesh.attributes.end() ? nullptr : &*found;
}

/// The attributes that the format has no room for.
std::vector<std::string> attributesLost(std::span<const NamedMesh> meshes,
                                        const MeshWriteOptions& options) {
  std::vector<std::string> lost;
  for (const NamedMesh& named : meshes) {
    const model::Attribute* uv = uvOf(named.mesh);
    const model::Attribute* colors = colorsOf(named);
    const bool hasMaterials = !writtenMaterials(named, options).empty();
    for (const model::Attribute& attribute : named.mesh.attributes) {
      if (&attribute == uv || &attribute == colors ||
          (hasMaterials && attribute.name == kMaterial)) {
        continue;
      }
      addOnce(lost, lostLine(attribute,
                             "OBJ has no attributes but texture coordinates, opaque colours of "
                             "vertices in bytes, and materials"));
    }
  }
  return lost;
}

}  // namespace

Result<std::vector<std::string>> writeObj(OutputFile& file, std::span<const NamedMesh> meshes,
                                          const MeshWriteOptions& options) {
  std::string text = "# written by t4d\n";
  if (const std::string origin = originComment(options); !origin.empty()) {
    text += "# " + origin + "\n";
  }
  const auto flush = [&]() -> Result<void> {
    auto done = file.write(text.data(), text.size());
    text.clear();
    return done;
  };
  std::uint64_t first = 1;
  std::uint64_t firstUv = 1;
  std::uint64_t firstNormal = 1;
  std::string material;  // of the faces so far
  for (const NamedMesh& named : meshes) {
    fmt::format_to(std::back_inserter(text), "o {}\n", onOneLine(named.name));
    // Colours after the coordinates are no part of the format, but many programs read them.
    const bool colored = hasColors({&named, 1}, model::Domain::Vertex, model::Domain::Vertex);
    const model::Attribute* colors = options.attributes ? colorsOf(named) : nullptr;
    for (std::size_t i = 0; i < named.mesh.vertices.size(); ++i) {
      const model::Point3 vertex = named.mesh.vertices[i] - options.center;
      std::string color;
      for (std::size_t k = 0; (colored || colors != nullptr) && k < 3; ++k) {
        const double byte =
            colored ? sRgbOf(named, model::Domain::Vertex, i)[k] : attributeNumber(*colors, i, k);
        color += fmt::format(" {:.4g}", byte / 255.0);
      }
      // "{}" is the shortest decimal that reads back as the same double.
      fmt::format_to(std::back_inserter(text), "v {} {} {}{}\n", vertex.x(), vertex.y(), vertex.z(),
                     color);
      if (auto done = flush(); !done) return done.error();
    }
    const model::Attribute* uv = options.attributes ? uvOf(named.mesh) : nullptr;
    const std::uint64_t uvCount = uv == nullptr ? 0 : uv->rows() * uv->components / 2;
    for (std::uint64_t i = 0; i < uvCount; ++i) {
      const std::uint64_t perRow = uv->components / 2;
      const auto number = [&](std::uint64_t k) {
        const double value = attributeNumber(*uv, i / perRow, 2 * (i % perRow) + k);
        return uv->type == model::ScalarType::Float32 ? fmt::format("{}", static_cast<float>(value))
                                                      : fmt::format("{}", value);
      };
      fmt::format_to(std::back_inserter(text), "vt {} {}\n", number(0), number(1));
      if (auto done = flush(); !done) return done.error();
    }
    VerticesWithNormals normals;
    if (options.normals) normals = withNormals(named.mesh, *options.normals);
    for (const Eigen::Vector3f& normal : normals.normals) {
      fmt::format_to(std::back_inserter(text), "vn {} {} {}\n", normal.x(), normal.y(), normal.z());
      if (auto done = flush(); !done) return done.error();
    }
    const std::vector<std::uint32_t> materials = writtenMaterials(named, options);
    for (std::size_t i = 0; i < named.mesh.triangles.size(); ++i) {
      const std::string& its = materials.empty() ? kNoMaterial : options.materials[materials[i]];
      if (its != material) fmt::format_to(std::back_inserter(text), "usemtl {}\n", onOneLine(its));
      material = its;
      text += "f";
      for (int corner = 0; corner < 3; ++corner) {
        fmt::format_to(std::back_inserter(text), " {}", first + named.mesh.triangles[i][corner]);
        if (uv != nullptr) {
          fmt::format_to(std::back_inserter(text), "/{}",
                         firstUv + uvNumber(*uv, named.mesh, i, static_cast<std::size_t>(corner)));
        }
        if (!options.normals) continue;
        fmt::format_to(std::back_inserter(text), "{}{}", uv != nullptr ? "/" : "//",
                       firstNormal + normals.triangles[i][corner]);
      }
      text += "\n";
      if (auto done = flush(); !done) return done.error();
    }
    firstUv += uvCount;
    firstNormal += normals.normals.size();
    first += named.mesh.vertices.size();
  }
  if (auto done = flush(); !done) return done.error();
  std::vector<std::string> lost;
  if (options.attributes) lost = attributesLost(meshes, options);
  if (hasColors(meshes, model::Domain::Cell, model::Domain::Vertex)) {
    lost.emplace_back("colours of triangles: OBJ has colours of vertices only");
  }
  return lost;
}

}  // namespace t4d::formats
