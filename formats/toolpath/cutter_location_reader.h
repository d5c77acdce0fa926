#pragma once

#include <filesystem>

#include "formats/input_file.h"
#include "formats/toolpath/tool_path.h"

namespace t4d::formats {

/// Reads cutter locations as CAM programs write them (APT, ISO 3592), a statement a line:
///
///     UNITS/MM
///     FEDRAT/300,MMPM
///     RAPID
///     GOTO/0,0,10,0,0,1      $$ tip and axis of the tool
///     GOTO/0,0,-2,0,0.5,0.8660254
///
/// Known are GOTO and FROM (a tip, and the direction from it to the shank, of any length; without
/// one the axis stays), FEDRAT (per minute, MMPM or IPM), RAPID for the next move, and UNITS.
/// Statements that move nothing are skipped: PARTNO, SPINDL, MULTAX and the like; END and FINI end
/// the file. LOADTL mounts a tool. A line that ends with $ is continued. A turn without a way
/// takes a second for every 36 degrees.
///
/// Fails, with the line, for all other statements, a tool that is not given, malformed numbers,
/// an axis of length zero, a move without feed, and what ToolPathBuilder refuses.
Result<ToolPath> readCutterLocations(const InputFile& file, const ToolPathOptions& options = {});
Result<ToolPath> readCutterLocations(const std::filesystem::path& path,
                                     const ToolPathOptions& options = {});

}  // namespace t4d::formats
