#pragma once

#include <optional>
#include <string_view>

#include "formats/toolpath/tool_path.h"

namespace t4d::formats {

/// What a control does where dialects differ and a program does not say which one it is.
struct GcodeHabits {
  GcodeDialect dialect = GcodeDialect::LinuxCnc;
  bool guessed = false;
  /// Lengths and angles without a point count thousandths (X5000 is 5 mm).
  bool wholeThousandths = false;
  bool retractsToLevel = false;    ///< canned cycles begin with G98
  bool millisecondDwells = false;  ///< P of G4, without a point
};

/// Those of a dialect, or of the one that a program looks like: of Fanuc's controls if it begins
/// with a line of % and one of O and a number, and has no O-words of LinuxCNC; its numbers count
/// thousandths then if none of them has a point and one is at least 1000.
GcodeHabits habitsOf(std::string_view program, std::optional<GcodeDialect> dialect);

}  // namespace t4d::formats
