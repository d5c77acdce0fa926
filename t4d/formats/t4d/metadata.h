#pragma once

#include <string>
#include <vector>

#include "t4d/model/error.h"

namespace t4d::formats {

/// What a .t4d file says about itself, in its HEAD chunk (JSON; SPEC.md, section "HEAD").
struct Metadata {
  std::string generator;            ///< program and version
  std::string backend;              ///< "mesh4d", "voxel4d", ...
  std::string lengthUnit;           ///< "mm", "m", ...; "" where not known
  std::string timeUnit;             ///< "s", ...
  std::string up = "y";             ///< the axis that points up: "y" or "z"
  std::vector<std::string> bodies;  ///< names, at least one, all different
  std::string detailsJson = "{}";   ///< a JSON object, free in form: source, parameters, ...
  /// What a reader must know to read the slabs. Set by readers; writers name what they use.
  std::vector<std::string> features;
};

/// The JSON text of a HEAD chunk whose reader must know `features`. Fails where the details are not
/// a JSON object, or all of it is too long.
Result<std::string> headText(const Metadata& metadata, const std::vector<std::string>& features);

/// Takes a HEAD chunk apart. Refuses text that is not UTF-8 JSON of the right form, and, by name,
/// features that this reader does not know. The error's offset is the byte of the text, where one
/// is to blame.
Result<Metadata> parseHead(const std::string& text);

}  // namespace t4d::formats
