#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "t4d/convert/frame_slices.h"
#include "t4d/model/body.h"
#include "t4d/model/sinks.h"

namespace t4d::convert {

/// From dark blue at 0 to yellow at 1, with evenly rising brightness (viridis).
formats::Color rampColor(double fraction);

/// Colours that are well apart for numbers that follow each other, in no order.
formats::Color distinctColor(std::uint64_t number);

/// How an attribute becomes colours:
/// * numbers (one component): rampColor from `low` to `high`, or distinctColor of whole numbers;
/// * three or four components: red, green, blue and opacity. Floating-point numbers are linear
///   from 0 to 1, UInt8 is 8-bit sRGB and UInt16 linear, as in glTF.
/// * vectors, by their `magnitude`: as numbers.
/// What has no colour is grey: numbers that are not finite, and, of the attribute "triangle", the
/// cells of caps.
struct AttributeColors {
  std::string attribute = {};
  bool distinct = false;
  std::uint32_t components = 1;
  bool magnitude = false;  ///< of several components: the length of the vector is the number
  double low = 0;          ///< of one number that is not distinct
  double high = 1;

  /// Gives the mesh the colours of its attribute, if it has it.
  void paint(formats::NamedMesh& named) const;
};

/// The colours of an attribute, whose range is that of all its numbers in these meshes, or in all
/// slabs of these bodies, which are read. Fails if no mesh or body has it, naming those there are,
/// or if it is not as above; not for meshes without triangles.
Result<AttributeColors> attributeColors(const std::string& attribute, bool distinct,
                                        std::span<const formats::NamedMesh> meshes);
Result<AttributeColors> attributeColors(const std::string& attribute, bool distinct,
                                        std::span<const model::Body> bodies,
                                        const model::Progress& progress = {});

}  // namespace t4d::convert
