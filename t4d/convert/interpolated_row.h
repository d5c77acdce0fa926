#pragma once

#include <cstddef>
#include <cstring>

#include "t4d/model/attribute.h"

namespace t4d::convert {

template <class Scalar>
void interpolateScalars(const std::byte* from, const std::byte* to, double fraction,
                        std::size_t components, std::byte* into) {
  for (std::size_t i = 0; i < components; ++i) {
    Scalar a;
    Scalar b;
    std::memcpy(&a, from + i * sizeof(Scalar), sizeof(Scalar));
    std::memcpy(&b, to + i * sizeof(Scalar), sizeof(Scalar));
    const auto value = static_cast<Scalar>(a + fraction * (static_cast<double>(b) - a));
    std::memcpy(into + i * sizeof(Scalar), &value, sizeof(Scalar));
  }
}

/// Sets `into` to the row of a vertex attribute at `fraction` of the way between two vertices; that
/// of the first one if the attribute has no floating-point numbers.
inline void interpolateRow(const model::Attribute& attribute, std::size_t from, std::size_t to,
                           double fraction, std::byte* into) {
  std::memcpy(into, attribute.row(from), attribute.rowBytes());
  if (attribute.type == model::ScalarType::Float64) {
    interpolateScalars<double>(attribute.row(from), attribute.row(to), fraction,
                               attribute.components, into);
  } else if (attribute.type == model::ScalarType::Float32) {
    interpolateScalars<float>(attribute.row(from), attribute.row(to), fraction,
                              attribute.components, into);
  }
}

}  // namespace t4d::convert
