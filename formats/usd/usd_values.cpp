#include "formats/usd/usd_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "formats/triangle/vertex_normals.h"
#include "formats/triangle/written_mesh.h"
#include "model/corner_attributes.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

using model::Attribute;
using model::Domain;
using model::ScalarType;

template <class T>
void putNumber(T number, std::string& text) {
  // "-nan" is not a word of USD.
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(number)) {
      text += "nan";
      return;
    }
  }
  model::appendNumber(text, number);
}

/// "[1,2]", or "[(1,2),(3,4)]" where `width` is more than 1.
template <class T>
std::string arrayText(std::span<const T> numbers, std::size_t width) {
  std::string text = "[";
  text.reserve(numbers.size() * 8);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text += ',';
    if (width > 1 && i % width == 0) text += '(';
    putNumber(numbers[i], text);
    if (width > 1 && i % width == width - 1) text += ')';
  }
  return text + "]";
}

template <class T>
UsdValue arrayValue(std::string type, std::string name, std::vector<T> numbers, std::size_t width,
                    std::string metadata = {}) {
  return {std::move(type), std::move(name), std::move(metadata), std::is_floating_point_v<T>,
          [numbers = std::move(numbers), width] {
            return arrayText(std::span<const T>(numbers), width);
          }};
}

std::string interpolation(std::string_view kind) {
  return fmt::format("interpolation = \"{}\"", kind);
}

std::vector<float> floatsOf(std::span<const Eigen::Vector3f> points) {
  std::vector<float> numbers;
  numbers.reserve(3 * points.size());
  for (const Eigen::Vector3f& point : points) {
    numbers.insert(numbers.end(), point.begin(), point.end());
  }
  return numbers;
}

UsdValue extentOf(std::span<const Eigen::Vector3f> points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& point : points) box.extend(point);
  if (points.empty()) box.extend(Eigen::Vector3f(Eigen::Vector3f::Zero()));
  const std::array<Eigen::Vector3f, 2> ends = {box.min(), box.max()};
  return arrayValue("float3[]", "extent", floatsOf(ends), 3);
}

/// One for each corner of a face, so that points keep their number; flat ones one for each face.
UsdValue normalsOf(const model::TriangleMesh& mesh, const NormalStyle& style) {
  const VerticesWithNormals with = withNormals(mesh, style);
  std::vector<Eigen::Vector3f> normals;
  for (const model::Triangle& triangle : with.triangles) {
    for (const std::uint32_t corner : std::span(triangle).first(style.flat ? 1 : 3)) {
      normals.push_back(with.normals[corner]);
    }
  }
  return arrayValue("normal3f[]", "normals", floatsOf(normals), 3,
                    interpolation(style.flat ? "uniform" : "faceVarying"));
}

void addColors(const NamedMesh& named, std::vector<UsdValue>& values) {
  std::vector<std::array<float, 4>> colors;
  const char* kind = "constant";
  if (named.colors) {
    colors = named.colors->colors;
    kind = named.colors->domain == Domain::Vertex ? "vertex" : "uniform";
  } else if (named.color) {
    auto& one = colors.emplace_back();
    std::ranges::transform(*named.color, one.begin(), [](double x) { return float(x); });
  } else {
    return;
  }
  std::vector<float> rgb;
  std::vector<float> opacity;
  for (const auto& color : colors) {
    rgb.insert(rgb.end(), color.begin(), color.begin() + 3);
    opacity.push_back(color[3]);
  }
  values.push_back(
      arrayValue("color3f[]", "primvars:displayColor", std::move(rgb), 3, interpolation(kind)));
  if (std::ranges::all_of(opacity, [](float x) { return x == 1; })) return;
  values.push_back(
      arrayValue("float[]", "primvars:displayOpacity", std::move(opacity), 1, interpolation(kind)));
}

/// The type of USD's arrays that holds these scalars.
const char* usdScalar(ScalarType type) {
  switch (type) {
    case ScalarType::UInt8:
      return "uchar";
    case ScalarType::UInt16:
    case ScalarType::UInt32:
      return "uint";
    case ScalarType::Int8:
    case ScalarType::Int16:
    case ScalarType::Int32:
      return "int";
    case ScalarType::UInt64:
      return "uint64";
    case ScalarType::Int64:
      return "int64";
    case ScalarType::Float32:
      return "float";
    case ScalarType::Float64:
      return "double";
  }
  return "double";
}

template <class T>
std::string numbersText(const Attribute& attribute, std::size_t width) {
  std::vector<T> numbers(attribute.values.size() / sizeof(T));
  std::memcpy(numbers.data(), attribute.values.data(), numbers.size() * sizeof(T));
  // A small integer would be a character.
  if constexpr (sizeof(T) == 1) {
    const std::vector<int> wide(numbers.begin(), numbers.end());
    return arrayText(std::span<const int>(wide), width);
  } else {
    return arrayText(std::span<const T>(numbers), width);
  }
}

std::string numbersText(const Attribute& attribute, std::size_t width) {
  switch (attribute.type) {
    case ScalarType::UInt8:
      return numbersText<std::uint8_t>(attribute, width);
    case ScalarType::Int8:
      return numbersText<std::int8_t>(attribute, width);
    case ScalarType::UInt16:
      return numbersText<std::uint16_t>(attribute, width);
    case ScalarType::Int16:
      return numbersText<std::int16_t>(attribute, width);
    case ScalarType::UInt32:
      return numbersText<std::uint32_t>(attribute, width);
    case ScalarType::Int32:
      return numbersText<std::int32_t>(attribute, width);
    case ScalarType::UInt64:
      return numbersText<std::uint64_t>(attribute, width);
    case ScalarType::Int64:
      return numbersText<std::int64_t>(attribute, width);
    case ScalarType::Float32:
      return numbersText<float>(attribute, width);
    case ScalarType::Float64:
      return numbersText<double>(attribute, width);
  }
  return "[]";
}

/// The attribute as a primvar. USD has the rows of a triangle's corners one after the other.
UsdValue primvarOf(const Attribute& attribute, bool ofCorners, const std::string& name) {
  const std::size_t components = attribute.components / (ofCorners ? 3 : 1);
  std::string type = usdScalar(attribute.type);
  const bool isUv = name == "st" && attribute.type == ScalarType::Float32;
  const bool hasTuples = type == "int" || type == "float" || type == "double";
  std::size_t width = 1;
  std::string metadata = interpolation(ofCorners                            ? "faceVarying"
                                       : attribute.domain == Domain::Vertex ? "vertex"
                                                                            : "uniform");
  if (hasTuples && components >= 2 && components <= 4) {
    width = components;
    type = isUv ? "texCoord2f" : fmt::format("{}{}", type, width);
  } else if (components > 1) {
    metadata = fmt::format("elementSize = {}\n{}", components, metadata);
  }
  const bool isFloat =
      attribute.type == ScalarType::Float32 || attribute.type == ScalarType::Float64;
  return {type + "[]", "primvars:" + name, metadata, isFloat,
          [&attribute, width] { return numbersText(attribute, width); }};
}

void addAttributes(const NamedMesh& named, std::vector<UsdValue>& values,
                   std::vector<std::string>& lost) {
  // Names that mean something else to players.
  std::set<std::string> taken = {"displayColor", "displayOpacity", "normals"};
  for (const Attribute& attribute : named.mesh.attributes) {
    const auto lose = [&](const char* why) { addOnce(lost, lostLine(attribute, why)); };
    const bool ofCorners = named.ownCorners && attribute.domain == Domain::Cell &&
                           attribute.name.ends_with(model::kCornersOf) &&
                           attribute.components % 3 == 0;
    const std::string given =
        ofCorners ? attribute.name.substr(0, attribute.name.size() - model::kCornersOf.size())
                  : attribute.name;
    const bool isUv = given == "uv" && attribute.components == (ofCorners ? 6 : 2);
    const std::string name = isUv ? "st" : usdName(given);
    if (given == kUsdVelocity && attribute.domain == Domain::Vertex && attribute.components == 3) {
      continue;
    }
    if (!fits(attribute, named.mesh)) {
      lose("its rows do not fit the mesh");
    } else if (!taken.insert(name).second) {
      lose("its name in USD is that of another");
    } else {
      values.push_back(primvarOf(attribute, ofCorners, name));
    }
  }
}

Result<void> addVelocities(const NamedMesh& named, std::vector<UsdValue>& values) {
  for (const Attribute& attribute : named.mesh.attributes) {
    if (attribute.name != kUsdVelocity || attribute.domain != Domain::Vertex ||
        attribute.components != 3 || !fits(attribute, named.mesh)) {
      continue;
    }
    std::vector<float> numbers;
    for (std::size_t row = 0; row < attribute.rows(); ++row) {
      for (std::size_t i = 0; i < 3; ++i) {
        numbers.push_back(static_cast<float>(attributeNumber(attribute, row, i)));
        if (std::isfinite(numbers.back())) continue;
        return invalid(
            fmt::format("mesh '{}': vertex {} has a velocity of {}, expected a number "
                        "that float32 holds",
                        named.name, row, attributeNumber(attribute, row, i)));
      }
    }
    values.push_back(arrayValue("vector3f[]", "velocities", std::move(numbers), 3));
  }
  return {};
}

}  // namespace

Result<std::vector<UsdValue>> usdMeshValues(const NamedMesh& named, const model::Point3& center,
                                            const MeshWriteOptions& options, RoundingLoss& rounding,
                                            std::vector<std::string>& lost) {
  if (auto good = checkWritable(named); !good) return good.error();
  const model::TriangleMesh& mesh = named.mesh;
  constexpr std::size_t kMostPoints = std::numeric_limits<std::int32_t>::max();
  if (mesh.vertices.size() > kMostPoints || mesh.triangles.size() > kMostPoints / 3) {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("mesh '{}' has more vertices or corners than USD's int can count", named.name));
  }
  const auto points = roundedVertices(named, center, rounding);
  if (!points) return points.error();
  std::vector<UsdValue> values;
  values.push_back({"int[]", "faceVertexCounts", "", false, [&mesh] {
                      const std::vector<int> counts(mesh.triangles.size(), 3);
                      return arrayText(std::span<const int>(counts), 1);
                    }});
  values.push_back({"int[]", "faceVertexIndices", "", false, [&mesh] {
                      const std::span<const std::uint32_t> corners(
                          mesh.triangles.empty() ? nullptr : mesh.triangles.front().data(),
                          3 * mesh.triangles.size());
                      return arrayText(corners, 1);
                    }});
  values.push_back(arrayValue("point3f[]", "points", floatsOf(*points), 3));
  values.push_back(extentOf(*points));
  if (options.normals) values.push_back(normalsOf(mesh, *options.normals));
  addColors(named, values);
  if (!options.attributes) return values;
  if (auto done = addVelocities(named, values); !done) return done.error();
  addAttributes(named, values, lost);
  return values;
}

std::string usdNumber(double number) {
  std::string text;
  putNumber(number, text);
  return text;
}

std::string usdTuple(std::initializer_list<double> numbers) {
  const std::string text =
      arrayText(std::span<const double>(std::data(numbers), numbers.size()), numbers.size());
  return text.substr(1, text.size() - 2);
}

std::string usdString(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\x{:02x}", static_cast<int>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string usdName(std::string_view name) {
  std::string plain = plainName(name);
  if (plain.empty() || (plain[0] >= '0' && plain[0] <= '9')) plain.insert(0, "_");
  return plain;
}

}  // namespace t4d::formats
