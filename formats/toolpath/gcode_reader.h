#pragma once

#include <filesystem>

#include "formats/input_file.h"
#include "formats/toolpath/tool_path.h"

namespace t4d::formats {

/// Reads a program for a mill in G-code (RS-274/NGC, ISO 6983). Where dialects differ it follows
/// LinuxCNC, or the control that ToolPathOptions::dialect names; macros and subprograms also are
/// Fanuc's (M98, M99, G65, WHILE, GOTO). docs/mill.md lists the words.
///
/// * GcodeProgram goes through the lines: O-words, macros, loops and calls, with a bound on what is
///   carried out, and GcodeParameters holds the values of #1 and #<name>;
/// * GcodeWords reads numbers and expressions, GcodeBlock the words of a line;
/// * GcodeMachine is the state that they set, and moves the tool: modal groups, offsets, canned
///   cycles, tools and rotary axes; CutterCompensation keeps the cutter beside the path.
///
/// Rapid moves before X, Y and Z have all been given are skipped; the path starts where they first
/// are, with rotary axes at zero. A cutting or relative move before that begins at
/// ToolPathOptions::start. Arcs, splines and turns become chords with ends on their paths. Dwells
/// take no time. Comments are in brackets or follow a semicolon; letters may be lower case, and
/// blanks may stand anywhere.
///
/// Fails, with the line, for all words that are not known, two words of one modal group in a line,
/// malformed numbers, words that nothing in the line reads, a cutting move without feed or tool
/// or after a place of the machine that is not known, an inner corner that is too narrow for the
/// cutter, a program that may never end, and what ToolPathBuilder refuses.
Result<ToolPath> readGcode(const InputFile& file, const ToolPathOptions& options = {});
Result<ToolPath> readGcode(const std::filesystem::path& path, const ToolPathOptions& options = {});

}  // namespace t4d::formats
