#pragma once

#include <filesystem>

#include "t4d/formats/input_file.h"
#include "t4d/formats/tool_path.h"

namespace t4d::formats {

/// Reads a program for a mill of three axes in G-code (RS-274, ISO 6983).
///
/// Moves: G0 G1 G2 G3 in the planes G17 G18 G19, arcs by centre (I J K) or radius (R), also
/// helices; units G20 G21; positions G90 G91, centres G91.1 (from the start of the arc, the
/// default) and G90.1; feed per minute. Words that move nothing are known and skipped (S, T, H, D,
/// N, O; M0 M1 M3 to M9; G4, G40, G43, G49, G61, G64, G80, G94, G97 to G99); M2 and M30 end the
/// program. G54 to G59.3 name the origin; all moves must have the same one. Comments are in
/// brackets or follow a semicolon. Letters may be lower case, and blanks may stand anywhere.
///
/// A dwell takes no time. Moves before X, Y and Z have all been given are skipped; the path starts
/// where they first are. Arcs become chords with ends on the arc.
///
/// Fails, with the line, for all other words, two words of one group in a line, numbers that are
/// none, a cutting move without feed or before the position is known, an arc without centre or one
/// that does not end on its circle, a second tool or origin, and what ToolPathBuilder refuses.
Result<ToolPath> readGcode(const InputFile& file, const ToolPathOptions& options = {});
Result<ToolPath> readGcode(const std::filesystem::path& path, const ToolPathOptions& options = {});

}  // namespace t4d::formats
