#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "formats/toolpath/gcode_words.h"
#include "formats/toolpath/tool_path.h"

namespace t4d::formats {

/// The modal groups of G words: words of one group exclude each other in a line.
enum class GcodeGroup : std::uint8_t {
  Motion,    ///< G0 to G3, splines, threads, canned cycles
  Cancel,    ///< G80
  NonModal,  ///< G4, G10, G28, G30, G52, G53, G92
  Plane,
  Units,
  Distance,
  Centres,
  Origin,
  FeedMode,
  Retract,       ///< G98, G99
  ToolLength,    ///< G43, G49
  Path,          ///< G61, G64
  Compensation,  ///< G40, G41, G42
  Polar,         ///< G15, G16
  Scale,         ///< G50, G51
  Mirror,        ///< G50.1, G51.1
  Rotation,      ///< G68, G69
  Harmless,      ///< G97; may come together
};
inline constexpr std::size_t kGcodeGroups = 18;

/// The words of a line. G words are counted in tenths, as in 592 for G59.2.
struct GcodeBlock {
  std::array<std::optional<int>, kGcodeGroups> codes = {};
  std::array<std::optional<double>, 6> axes = {};    ///< X Y Z A B C
  std::array<std::optional<double>, 3> centre = {};  ///< I J K
  std::optional<double> d = {}, f = {}, h = {}, l = {}, p = {}, q = {}, r = {}, s = {}, t = {};
  std::optional<double> radius = {}, angle = {};    ///< @ and ^: X and Y as polar coordinates
  std::optional<double> corner = {}, chamfer = {};  ///< ,R and ,C
  std::optional<double> dwell = {};                 ///< U of G4
  /// The letters of a line with G65, by letter from A: arguments of the macro.
  std::array<std::optional<double>, 26> arguments = {};
  bool changesTool = false;  ///< M6
  bool namesTool = false;    ///< M61
  bool calls = false;        ///< M98, G65
  bool isMacro = false;      ///< G65
  bool isLocal = false;      ///< M97: P is a number of a line, N
  bool returns = false;      ///< M99
  bool ends = false;         ///< M2, M30
  /// M70 to M73: modes are saved, forgotten, restored, saved for the end of the subprogram; or 0.
  int saves = 0;
  bool talks = false;       ///< a word of the control, whose P, Q, E and L move nothing
  std::uint32_t whole = 0;  ///< letters whose numbers have no point, by bit

  std::optional<int> code(GcodeGroup group) const { return codes[static_cast<std::size_t>(group)]; }
  bool hasAxes() const;
  /// Whether the number of this letter has digits only, and no point.
  bool isWhole(char letter) const;
  void markWhole(char letter);
  bool hasCentre() const { return centre != GcodeBlock{}.centre; }
};

/// "G59.2" of 592.
std::string gcodeWord(int tenths);

/// Reads the words of a line without N and O, sets the parameters that it assigns to after all of
/// them have been read, and refuses words that are not known.
Result<GcodeBlock> readGcodeBlock(std::string_view text, GcodeDialect dialect,
                                  GcodeParameters& parameters);

}  // namespace t4d::formats
