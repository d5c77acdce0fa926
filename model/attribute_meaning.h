#pragma once

#include <map>
#include <string>
#include <string_view>

#include "model/attribute.h"
#include "model/error.h"

namespace t4d::model {

struct Transform;

/// What the numbers of an attribute mean, so that they can be mapped together with the solid
/// (formats/t4d/SPEC.md, section "Kinds of attributes").
struct AttributeMeaning {
  /// "scalar", "vector", "point", "normal", "color" or "label"; "" is "scalar".
  std::string kind;
  /// A product of powers, in which `length` and `time` are the units of the file: "length/time",
  /// "1/time^2", "N"; "" for none.
  std::string unit;
  /// Further members of its JSON object, kept as they are.
  std::string otherJson = "{}";

  friend bool operator==(const AttributeMeaning&, const AttributeMeaning&) = default;
};

/// Maps the names of attributes to their meanings.
using AttributeMeanings = std::map<std::string, AttributeMeaning>;

/// The meaning in `given`; otherwise that of the name if the format registers it with this type,
/// such as `velocity`; otherwise the default.
AttributeMeaning meaningOf(const Attribute& attribute, const AttributeMeanings& given);

/// Whether the values are directions or positions in space: a vector, a point or a normal.
bool isSpatial(const AttributeMeaning& meaning);

/// The powers of `length` and `time` in a unit. Both are 0 for a unit that is not a product of
/// powers.
struct UnitPowers {
  int length = 0;
  int time = 0;
};
UnitPowers powersOf(std::string_view unit);

/// Maps the values of an attribute with the solid: vectors turn and stretch, points move, normals
/// stay perpendicular to their surface and keep their length, numbers in units of length and time
/// are scaled; labels and colours stay. Returns whether any value may have changed. Fails with
/// ErrorCode::Unsupported if the attribute cannot be mapped: for a unit of length if the map does
/// not scale all directions by the same factor, for types and components that the kind cannot have,
/// and for an unknown kind. Fails with ErrorCode::InvalidInput if a value becomes infinite, or a
/// whole row 0.
Result<bool> mapValues(Attribute& attribute, const AttributeMeaning& meaning, const Transform& by);

}  // namespace t4d::model
