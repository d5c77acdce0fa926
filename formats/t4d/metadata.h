#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/file.h"

namespace t4d::formats {

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
