#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <pybind11/numpy.h>

#include "python/bindings/errors.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::python {

// New arrays are given their strides: pybind11 before 2.12 finds a wrong size of items in numpy 2.

/// A read-only array of rows of numbers that keeps `owner`, and with it the memory, alive.
template <class T>
py::array view(const T* data, std::size_t rows, std::size_t columns, const py::handle& owner) {
  const auto width = static_cast<py::ssize_t>(sizeof(T));
  const auto count = static_cast<py::ssize_t>(columns);
  py::array array(py::dtype::of<T>(), {static_cast<py::ssize_t>(rows), count},
                  {count * width, width}, data, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// (n, 3) float64.
inline py::array viewOf(const std::vector<model::Point3>& points, const py::handle& owner) {
  return view(reinterpret_cast<const double*>(points.data()), points.size(), 3, owner);
}
/// (n, 4) float64.
inline py::array viewOf(const std::vector<model::Point4>& points, const py::handle& owner) {
  return view(reinterpret_cast<const double*>(points.data()), points.size(), 4, owner);
}
/// (n, 3) or (n, 4) uint32.
template <std::size_t N>
py::array viewOf(const std::vector<std::array<std::uint32_t, N>>& rows, const py::handle& owner) {
  return view(reinterpret_cast<const std::uint32_t*>(rows.data()), rows.size(), N, owner);
}

/// (n,) or (n, components).
py::array viewOf(const model::Attribute& attribute, const py::handle& owner);

/// A dict from the name of each attribute of the domain to its array.
py::dict viewsOf(std::span<const model::Attribute> attributes, model::Domain domain,
                 const py::handle& owner);

/// A row for each of `rows`, of any of the types of numbers that attributes have.
model::Attribute attributeOf(const std::string& name, model::Domain domain, const py::array& array,
                             std::size_t rows);

/// Points from (n, 3) finite numbers.
std::vector<model::Point3> pointsOf(const py::array& array, const std::string& what);
/// Triangles from (n, 3) whole numbers that are not negative.
std::vector<model::Triangle> trianglesOf(const py::array& array, std::size_t vertexCount);

}  // namespace t4d::python
