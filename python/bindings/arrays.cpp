#include "python/bindings/arrays.h"

#include <limits>
#include <new>
#include <utility>

#include <fmt/format.h>

namespace t4d::python {
namespace {

py::dtype dtypeOf(model::ScalarType type) {
  using model::ScalarType;
  switch (type) {
    case ScalarType::UInt8:
      return py::dtype::of<std::uint8_t>();
    case ScalarType::Int8:
      return py::dtype::of<std::int8_t>();
    case ScalarType::UInt16:
      return py::dtype::of<std::uint16_t>();
    case ScalarType::Int16:
      return py::dtype::of<std::int16_t>();
    case ScalarType::UInt32:
      return py::dtype::of<std::uint32_t>();
    case ScalarType::Int32:
      return py::dtype::of<std::int32_t>();
    case ScalarType::UInt64:
      return py::dtype::of<std::uint64_t>();
    case ScalarType::Int64:
      return py::dtype::of<std::int64_t>();
    case ScalarType::Float32:
      return py::dtype::of<float>();
    case ScalarType::Float64:
      return py::dtype::of<double>();
  }
  throw py::value_error("unknown type of numbers");
}

constexpr model::ScalarType kScalarTypes[] = {
    model::ScalarType::UInt8,   model::ScalarType::Int8,   model::ScalarType::UInt16,
    model::ScalarType::Int16,   model::ScalarType::UInt32, model::ScalarType::Int32,
    model::ScalarType::UInt64,  model::ScalarType::Int64,  model::ScalarType::Float32,
    model::ScalarType::Float64,
};

std::string shapeText(const py::array& array) { return py::str(py::object(array.attr("shape"))); }

}  // namespace

py::array viewOf(const model::Attribute& attribute, const py::handle& owner) {
  const auto width = static_cast<py::ssize_t>(model::scalarSize(attribute.type));
  const auto components = static_cast<py::ssize_t>(attribute.components);
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(attribute.rows())};
  std::vector<py::ssize_t> strides = {components * width};
  if (components > 1) shape.push_back(components), strides.push_back(width);
  py::array array(dtypeOf(attribute.type), shape, strides, attribute.values.data(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

py::dict viewsOf(std::span<const model::Attribute> attributes, model::Domain domain,
                 const py::handle& owner) {
  py::dict views;
  for (const model::Attribute& attribute : attributes) {
    if (attribute.domain == domain) views[py::str(attribute.name)] = viewOf(attribute, owner);
  }
  return views;
}

model::Attribute attributeOf(const std::string& name, model::Domain domain, const py::array& array,
                             std::size_t rows) {
  if (array.ndim() < 1 || array.ndim() > 2 || static_cast<std::size_t>(array.shape(0)) != rows) {
    throw py::value_error(
        fmt::format("attribute '{}' has the shape {}; expected ({},) or ({}, components)", name,
                    shapeText(array), rows, rows));
  }
  for (const model::ScalarType type : kScalarTypes) {
    if (!array.dtype().equal(dtypeOf(type))) continue;
    const auto packed = py::array::ensure(array, py::array::c_style);
    if (!packed) throw std::bad_alloc();
    model::Attribute attribute{name, domain, type, 1, {}};
    if (array.ndim() == 2) attribute.components = static_cast<std::uint32_t>(array.shape(1));
    const auto* bytes = static_cast<const std::byte*>(packed.data());
    attribute.values.assign(bytes, bytes + rows * attribute.rowBytes());
    return attribute;
  }
  throw py::value_error(
      fmt::format("attribute '{}' has numbers of type {}; whole numbers of 8 to 64 bits, float32 "
                  "and float64 can be kept",
                  name, std::string(py::str(py::object(array.dtype())))));
}

std::vector<model::Point3> pointsOf(const py::array& array, const std::string& what) {
  if (array.ndim() != 2 || array.shape(1) != 3) {
    throw py::value_error(
        fmt::format("{} have the shape {}; expected (n, 3)", what, shapeText(array)));
  }
  const py::array_t<double, py::array::c_style | py::array::forcecast> packed(array);
  std::vector<model::Point3> points(static_cast<std::size_t>(packed.shape(0)));
  const auto rows = packed.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    model::Point3& point = points[static_cast<std::size_t>(i)];
    point = {rows(i, 0), rows(i, 1), rows(i, 2)};
    if (!point.allFinite()) {
      throw py::value_error(fmt::format("{}[{}] is ({}, {}, {}); expected finite numbers", what, i,
                                        point[0], point[1], point[2]));
    }
  }
  return points;
}

namespace {

template <class Index>
std::vector<model::Triangle> trianglesFrom(const py::array& array, std::size_t vertexCount) {
  const py::array_t<Index, py::array::c_style | py::array::forcecast> packed(array);
  const auto rows = packed.template unchecked<2>();
  std::vector<model::Triangle> triangles(static_cast<std::size_t>(rows.shape(0)));
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    for (py::ssize_t k = 0; k < 3; ++k) {
      const Index index = rows(i, k);
      if (std::cmp_less(index, 0) || std::cmp_greater_equal(index, vertexCount) ||
          std::cmp_greater(index, std::numeric_limits<std::uint32_t>::max())) {
        throw py::value_error(
            fmt::format("triangles[{}][{}] is {}; expected the index of one of {} vert{}, from 0",
                        i, k, index, vertexCount, vertexCount == 1 ? "ex" : "ices"));
      }
      triangles[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
          static_cast<std::uint32_t>(index);
    }
  }
  return triangles;
}

}  // namespace

std::vector<model::Triangle> trianglesOf(const py::array& array, std::size_t vertexCount) {
  if (array.ndim() != 2 || array.shape(1) != 3) {
    throw py::value_error(
        fmt::format("triangles have the shape {}; expected (m, 3)", shapeText(array)));
  }
  const char kind = array.dtype().kind();
  if (kind == 'i') return trianglesFrom<std::int64_t>(array, vertexCount);
  if (kind == 'u') return trianglesFrom<std::uint64_t>(array, vertexCount);
  throw py::value_error("triangles are whole numbers, the indices of vertices");
}

}  // namespace t4d::python
