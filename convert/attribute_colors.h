#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "t4d/convert.h"
#include "t4d/mesh.h"

namespace t4d::convert {

/// A colour from dark blue at 0 to yellow at 1, with evenly increasing brightness (viridis).
formats::Color rampColor(double fraction);

/// A colour for a number; consecutive numbers have very different colours.
formats::Color distinctColor(std::uint64_t number);

/// How an attribute becomes colours:
/// * numbers (one component): rampColor from `low` to `high`, or distinctColor of whole numbers;
/// * three or four components: red, green, blue and opacity. Floating-point numbers are linear
///   from 0 to 1, UInt8 is 8-bit sRGB and UInt16 linear, as in glTF.
/// * vectors, by their `magnitude`: as numbers.
/// Numbers that are not finite, and cells of caps for the attribute "triangle", are grey.
struct AttributeColors {
  std::string attribute = {};
  bool distinct = false;
  std::uint32_t components = 1;
  bool magnitude = false;  ///< colour by the length of the vector
  double low = 0;          ///< range of rampColor
  double high = 1;

  /// Colours the mesh by its attribute, if it has this attribute.
  void paint(formats::NamedMesh& named) const;
};

/// The colours of an attribute, with the range of all its numbers in these meshes, or in all slabs
/// of these bodies, which are read. Fails if no mesh or body has the attribute (the error lists
/// those there are), or if it cannot become colours. Does not fail for meshes without triangles.
Result<AttributeColors> attributeColors(const std::string& attribute, bool distinct,
                                        std::span<const formats::NamedMesh> meshes);
Result<AttributeColors> attributeColors(const std::string& attribute, bool distinct,
                                        std::span<const model::Body> bodies,
                                        const model::Progress& progress = {});

}  // namespace t4d::convert
