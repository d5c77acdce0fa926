#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace t4d::model {

/// The type of the numbers in an attribute. Enumerator values are those of the file format
/// (formats/t4d/SPEC.md).
enum class ScalarType : std::uint8_t {
  UInt8 = 1,
  Int8 = 2,
  UInt16 = 3,
  Int16 = 4,
  UInt32 = 5,
  Int32 = 6,
  UInt64 = 7,
  Int64 = 8,
  Float32 = 9,
  Float64 = 10,
};

/// Bytes of one scalar; 0 for a value that is not a ScalarType.
std::size_t scalarSize(ScalarType type);

/// What each row belongs to. A cell is a tetrahedron of a 4D mesh, or a triangle of a slice.
enum class Domain : std::uint8_t { Vertex = 1, Cell = 2 };

/// A named array of numbers with one row per vertex or per cell.
struct Attribute {
  std::string name = {};
  Domain domain = Domain::Cell;
  ScalarType type = ScalarType::Float64;
  std::uint32_t components = 1;
  /// All rows in order, `rowBytes()` bytes each, in the machine's byte order.
  std::vector<std::byte> values = {};

  std::size_t rowBytes() const { return scalarSize(type) * components; }
  std::size_t rows() const { return rowBytes() == 0 ? 0 : values.size() / rowBytes(); }
  const std::byte* row(std::size_t index) const { return values.data() + index * rowBytes(); }

  friend bool operator==(const Attribute&, const Attribute&) = default;
};

/// Writes to `into` the values at a point on the edge between the vertices of two rows, at
/// `fraction` of the way: floating-point numbers are interpolated, integers are those of the first
/// row.
void interpolateRow(const Attribute& attribute, std::size_t from, std::size_t to, double fraction,
                    std::byte* into);

/// The attributes of domain Vertex, with `count` rows from row `first` on.
std::vector<Attribute> vertexRows(std::span<const Attribute> attributes, std::size_t first,
                                  std::size_t count);

template <class T>
constexpr ScalarType scalarTypeOf();
template <>
constexpr ScalarType scalarTypeOf<std::uint8_t>() {
  return ScalarType::UInt8;
}
template <>
constexpr ScalarType scalarTypeOf<std::int8_t>() {
  return ScalarType::Int8;
}
template <>
constexpr ScalarType scalarTypeOf<std::uint16_t>() {
  return ScalarType::UInt16;
}
template <>
constexpr ScalarType scalarTypeOf<std::int16_t>() {
  return ScalarType::Int16;
}
template <>
constexpr ScalarType scalarTypeOf<std::uint32_t>() {
  return ScalarType::UInt32;
}
template <>
constexpr ScalarType scalarTypeOf<std::int32_t>() {
  return ScalarType::Int32;
}
template <>
constexpr ScalarType scalarTypeOf<std::uint64_t>() {
  return ScalarType::UInt64;
}
template <>
constexpr ScalarType scalarTypeOf<std::int64_t>() {
  return ScalarType::Int64;
}
template <>
constexpr ScalarType scalarTypeOf<float>() {
  return ScalarType::Float32;
}
template <>
constexpr ScalarType scalarTypeOf<double>() {
  return ScalarType::Float64;
}

/// An attribute with one component per row, copied from `values`.
template <class T>
Attribute makeAttribute(std::string name, Domain domain, const std::vector<T>& values) {
  const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
  return {std::move(name), domain, scalarTypeOf<T>(), 1,
          std::vector<std::byte>(bytes, bytes + values.size() * sizeof(T))};
}

}  // namespace t4d::model
