#pragma once

#include <map>
#include <string>
#include <string_view>

#include "t4d/model/attribute.h"
#include "t4d/model/error.h"

namespace t4d::model {

struct Transform;

/// What the numbers of an attribute are, so that they can follow the solid when it is mapped
/// (t4d/formats/t4d/SPEC.md, section "Kinds of attributes").
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

/// By the names of the attributes.
using AttributeMeanings = std::map<std::string, AttributeMeaning>;

/// What `given` says of this attribute; otherwise what its name means if the format registers it
/// with this type, such as `velocity`; otherwise nothing.
AttributeMeaning meaningOf(const Attribute& attribute, const AttributeMeanings& given);

/// Whether its values are directions or places in space: of a vector, a point or a normal.
bool isSpatial(const AttributeMeaning& meaning);

/// How often `length` and `time` are factors of a unit. A unit that is not a product of powers has
/// neither.
struct UnitPowers {
  int length = 0;
  int time = 0;
};
UnitPowers powersOf(std::string_view unit);

/// Maps the values of an attribute with the solid: vectors turn and stretch, points move, normals
/// stay perpendicular to their surface and keep their length, numbers in units of length and time
/// are scaled; labels and colours stay. Returns whether any value may have changed. Fails with
/// ErrorCode::Unsupported if no values of this attribute can follow: for a unit that needs a scale
/// where the map does not scale all directions alike, for types and components that the kind cannot
/// have, and for a kind that is not known. Fails with ErrorCode::InvalidInput if a value becomes
/// infinite, or all of a row 0.
Result<bool> mapValues(Attribute& attribute, const AttributeMeaning& meaning, const Transform& by);

}  // namespace t4d::model
