#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/t4d/grid.h"
#include "model/attribute_meaning.h"
#include "model/error.h"

namespace t4d::formats {

/// What HEAD says of a body.
struct BodyInfo {
  std::string name = {};  ///< checkName accepts it
  std::vector<double> color =
      {};  ///< linear red, green, blue, perhaps opacity, from 0 to 1; or none
  std::string material = {};
  std::string parent = {};         ///< name of another body; "" for none
  std::string detailsJson = "{}";  ///< a JSON object
  std::string otherJson = "{}";    ///< a JSON object of its members that are not known
};

/// Metadata of a .t4d file, in its HEAD chunk (JSON; SPEC.md, section "HEAD").
struct Metadata {
  std::string generator = {};   ///< program and version
  std::string backend = {};     ///< "mesh4d", "voxel4d", ...
  std::string lengthUnit = {};  ///< "mm", "m", ...; "" if unknown
  std::string timeUnit = {};    ///< "s", ...
  std::string up = "y";         ///< the axis that points up: "y" or "z"
  std::string space = {};       ///< where the axes point in a patient: "RAS", "LPS", or ""
  model::AttributeMeanings attributes = {};  ///< of attributes that slabs may have
  std::vector<BodyInfo> bodies = {};         ///< at least one, with different names
  std::string detailsJson = "{}";  ///< a JSON object with any members: source, parameters, ...
  /// A JSON object of the members that are not known. Written as they were read; members of the
  /// same name in this struct come first.
  std::string otherJson = "{}";
  /// What a reader must support to read the slabs. Set by readers; writers name the features they
  /// use.
  std::vector<std::string> features = {};
  /// What positions of whole numbers mean. Set by readers.
  std::optional<Grid> grid = {};
};

/// The lowest minor version of the format that has the members of HEAD that this needs.
std::uint16_t minorVersionFor(const Metadata& metadata);

/// The JSON text of a HEAD chunk whose readers must support `features`, with this grid. Fails for
/// details that are not a JSON object, a space that the format does not have, and a text that is
/// too long.
Result<std::string> headText(const Metadata& metadata, const std::vector<std::string>& features,
                             const std::optional<Grid>& grid = {});

/// Metadata of several files, for one that has what all of them have. They agree in all that says
/// how to read the numbers; attributes that any of them describes are described. Of members that
/// this version does not know, those are kept that do not differ; `lost` gets a line for the
/// others.
Metadata joinedMetadata(const std::vector<const Metadata*>& files, std::vector<std::string>& lost);

/// Parses a HEAD chunk. Rejects text that is not UTF-8 JSON of the right form, and unsupported
/// features, by name. `space` and `attributes` of another form are members that are not known. The
/// error's offset is relative to the text, and set only if a certain byte is at fault.
Result<Metadata> parseHead(const std::string& text);

}  // namespace t4d::formats
