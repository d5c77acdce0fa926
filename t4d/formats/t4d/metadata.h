#pragma once

#include <optional>
#include <string>
#include <vector>

#include "t4d/formats/t4d/grid.h"
#include "t4d/model/error.h"

namespace t4d::formats {

/// What HEAD says of a body.
struct BodyInfo {
  std::string name;  ///< checkName accepts it
  std::vector<double> color =
      {};  ///< linear red, green, blue, perhaps opacity, from 0 to 1; or none
  std::string material = {};
  std::string parent = {};         ///< name of another body; "" for none
  std::string detailsJson = "{}";  ///< a JSON object
};

/// Metadata of a .t4d file, in its HEAD chunk (JSON; SPEC.md, section "HEAD").
struct Metadata {
  std::string generator;           ///< program and version
  std::string backend;             ///< "mesh4d", "voxel4d", ...
  std::string lengthUnit;          ///< "mm", "m", ...; "" if unknown
  std::string timeUnit;            ///< "s", ...
  std::string up = "y";            ///< the axis that points up: "y" or "z"
  std::vector<BodyInfo> bodies;    ///< at least one, with different names
  std::string detailsJson = "{}";  ///< a JSON object with any members: source, parameters, ...
  /// What a reader must support to read the slabs. Set by readers; writers name the features they
  /// use.
  std::vector<std::string> features;
  /// What positions of whole numbers mean. Set by readers.
  std::optional<Grid> grid = {};
};

/// The JSON text of a HEAD chunk whose readers must support `features`, with this grid. Fails if
/// the details are not a JSON object, or if the text is too long.
Result<std::string> headText(const Metadata& metadata, const std::vector<std::string>& features,
                             const std::optional<Grid>& grid = {});

/// Parses a HEAD chunk. Rejects text that is not UTF-8 JSON of the right form, and unsupported
/// features, by name. The error's offset is relative to the text, and set only if a certain byte is
/// at fault.
Result<Metadata> parseHead(const std::string& text);

}  // namespace t4d::formats
