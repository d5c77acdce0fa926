#include <cstring>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

template <class Scalar>
void interpolate(const std::byte* from, const std::byte* to, double fraction, std::byte* into) {
  Scalar a;
  Scalar b;
  std::memcpy(&a, from, sizeof(Scalar));
  std::memcpy(&b, to, sizeof(Scalar));
  const auto value = static_cast<Scalar>(a + fraction * (static_cast<double>(b) - a));
  std::memcpy(into, &value, sizeof(Scalar));
}

}  // namespace

std::size_t scalarSize(ScalarType type) {
  switch (type) {
    case ScalarType::UInt8:
    case ScalarType::Int8:
      return 1;
    case ScalarType::UInt16:
    case ScalarType::Int16:
      return 2;
    case ScalarType::UInt32:
    case ScalarType::Int32:
    case ScalarType::Float32:
      return 4;
    case ScalarType::UInt64:
    case ScalarType::Int64:
    case ScalarType::Float64:
      return 8;
  }
  return 0;
}

void interpolateRow(const Attribute& attribute, std::size_t from, std::size_t to, double fraction,
                    std::byte* into) {
  const std::byte* const a = attribute.row(from);
  const std::byte* const b = attribute.row(to);
  const std::size_t bytes = attribute.rowBytes();
  const std::size_t step = scalarSize(attribute.type);
  switch (attribute.type) {
    case ScalarType::Float32:
      for (std::size_t i = 0; i < bytes; i += step)
        interpolate<float>(a + i, b + i, fraction, into + i);
      break;
    case ScalarType::Float64:
      for (std::size_t i = 0; i < bytes; i += step)
        interpolate<double>(a + i, b + i, fraction, into + i);
      break;
    default:
      std::memcpy(into, a, bytes);
  }
}

std::vector<Attribute> vertexRows(std::span<const Attribute> attributes, std::size_t first,
                                  std::size_t count) {
  std::vector<Attribute> cut;
  for (const Attribute& attribute : attributes) {
    if (attribute.domain != Domain::Vertex) continue;
    const std::byte* const begin = attribute.row(first);
    cut.push_back({attribute.name,
                   Domain::Vertex,
                   attribute.type,
                   attribute.components,
                   {begin, begin + count * attribute.rowBytes()}});
  }
  return cut;
}

}  // namespace t4d::model
