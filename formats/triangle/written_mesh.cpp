#include "formats/triangle/written_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "formats/triangle/vertex_normals.h"

namespace t4d::formats {
namespace {

template <class T>
double load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return static_cast<double>(value);
}

Place meshNamed(const NamedMesh& named) {
  return placeIn({}, fmt::format("mesh '{}'", named.name));
}

}  // namespace

Result<void> checkWritable(const NamedMesh& named) {
  const auto& [vertices, triangles, attributes] = named.mesh;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i].allFinite()) continue;
    return invalid(fmt::format("vertex {} is ({}, {}, {}), expected finite coordinates", i,
                               vertices[i].x(), vertices[i].y(), vertices[i].z()),
                   meshNamed(named));
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto largest = *std::ranges::max_element(triangles[i]);
    if (largest < vertices.size()) continue;
    return invalid(fmt::format("triangle {} refers to vertex {}, but there are {} (counted from 0)",
                               i, largest, vertices.size()),
                   meshNamed(named));
  }
  if (named.colors) {
    const bool ofVertices = named.colors->domain == model::Domain::Vertex;
    const std::size_t expected = ofVertices ? vertices.size() : triangles.size();
    if (named.colors->colors.size() != expected) {
      return invalid(fmt::format("{} colours for {} {}", named.colors->colors.size(), expected,
                                 ofVertices ? "vertices" : "triangles"),
                     meshNamed(named));
    }
  }
  return {};
}

Result<std::vector<Eigen::Vector3f>> roundedVertices(const NamedMesh& named,
                                                     const model::Point3& center,
                                                     RoundingLoss& loss) {
  std::vector<Eigen::Vector3f> rounded;
  rounded.reserve(named.mesh.vertices.size());
  for (const model::Point3& given : named.mesh.vertices) {
    const model::Point3 vertex = given - center;
    if (!(vertex.cwiseAbs().maxCoeff() <= std::numeric_limits<float>::max())) {
      return invalid(fmt::format("vertex {} is ({}, {}, {}), beyond the float32 numbers that the "
                                 "format has",
                                 rounded.size(), vertex.x(), vertex.y(), vertex.z()),
                     meshNamed(named));
    }
    rounded.push_back(vertex.cast<float>());
  }
  loss.add(named.mesh, rounded);
  return rounded;
}

std::string originComment(const MeshWriteOptions& options) {
  const model::Point3 origin = options.origin + options.center;
  if (origin.isZero(0)) return {};
  return fmt::format("origin {} {} {}", origin.x(), origin.y(), origin.z());
}

double attributeNumber(const model::Attribute& attribute, std::size_t row, std::size_t component) {
  using model::ScalarType;
  const std::byte* from = attribute.row(row) + component * model::scalarSize(attribute.type);
  switch (attribute.type) {
    case ScalarType::UInt8:
      return load<std::uint8_t>(from);
    case ScalarType::Int8:
      return load<std::int8_t>(from);
    case ScalarType::UInt16:
      return load<std::uint16_t>(from);
    case ScalarType::Int16:
      return load<std::int16_t>(from);
    case ScalarType::UInt32:
      return load<std::uint32_t>(from);
    case ScalarType::Int32:
      return load<std::int32_t>(from);
    case ScalarType::UInt64:
      return load<std::uint64_t>(from);
    case ScalarType::Int64:
      return load<std::int64_t>(from);
    case ScalarType::Float32:
      return load<float>(from);
    case ScalarType::Float64:
      return load<double>(from);
  }
  return 0;
}

bool fits(const model::Attribute& attribute, const model::TriangleMesh& mesh) {
  const std::size_t rows =
      attribute.domain == model::Domain::Vertex ? mesh.vertices.size() : mesh.triangles.size();
  return attribute.rowBytes() > 0 && attribute.values.size() == rows * attribute.rowBytes();
}

std::vector<std::uint32_t> writtenMaterials(const NamedMesh& named,
                                            const MeshWriteOptions& options) {
  if (!options.attributes || options.materials.empty()) return {};
  for (const model::Attribute& attribute : named.mesh.attributes) {
    if (attribute.name != kMaterial || attribute.domain != model::Domain::Cell ||
        attribute.type != model::ScalarType::UInt32 || attribute.components != 1 ||
        !fits(attribute, named.mesh)) {
      continue;
    }
    std::vector<std::uint32_t> numbers(attribute.rows());
    std::memcpy(numbers.data(), attribute.values.data(), attribute.values.size());
    const bool areNamed = std::ranges::all_of(
        numbers, [&](std::uint32_t number) { return number < options.materials.size(); });
    return areNamed ? numbers : std::vector<std::uint32_t>();
  }
  return {};
}

std::string plainName(std::string_view name) {
  std::string plain(name);
  for (char& c : plain) {
    const bool kept = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!kept) c = '_';
  }
  return plain;
}

std::string lostLine(const model::Attribute& attribute, std::string_view why) {
  return fmt::format("{} attribute '{}': {}",
                     attribute.domain == model::Domain::Vertex ? "vertex" : "triangle",
                     attribute.name, why);
}

std::vector<std::string> allAttributesLost(std::span<const NamedMesh> meshes,
                                           std::string_view why) {
  std::vector<std::string> lost;
  for (const NamedMesh& named : meshes) {
    for (const auto& attribute : named.mesh.attributes) addOnce(lost, lostLine(attribute, why));
  }
  return lost;
}

VerticesWithNormals verticesToWrite(const NamedMesh& named, const MeshWriteOptions& options) {
  return options.normals ? withNormals(named.mesh, *options.normals) : withoutNormals(named.mesh);
}

std::array<std::uint8_t, 4> sRgbOf(const Color& color) {
  std::array<std::uint8_t, 4> bytes{};
  for (std::size_t i = 0; i < 4; ++i) {
    double value = std::clamp(color[i], 0.0, 1.0);
    // IEC 61966-2-1; opacity is linear.
    if (i < 3) {
      value = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
    }
    bytes[i] = static_cast<std::uint8_t>(std::lround(255 * value));
  }
  return bytes;
}

bool hasColors(std::span<const NamedMesh> meshes, model::Domain domain, model::Domain single) {
  return std::ranges::any_of(meshes, [&](const NamedMesh& named) {
    if (named.colors) return named.colors->domain == domain;
    return named.color && domain == single;
  });
}

std::array<std::uint8_t, 4> sRgbOf(const NamedMesh& named, model::Domain domain, std::size_t row) {
  constexpr Color kGrey = {0.8, 0.8, 0.8, 1};
  if (!named.colors || named.colors->domain != domain) return sRgbOf(named.color.value_or(kGrey));
  Color color{};
  std::ranges::copy(named.colors->colors[row], color.begin());
  return sRgbOf(color);
}

void addOnce(std::vector<std::string>& lines, std::string line) {
  if (std::ranges::find(lines, line) == lines.end()) lines.push_back(std::move(line));
}

Error inFile(const std::filesystem::path& path, Error error) {
  if (error.code != ErrorCode::Failed || error.where.empty()) {
    error.where = placeIn(path.string(), error.where.text());
  }
  return error;
}

}  // namespace t4d::formats
