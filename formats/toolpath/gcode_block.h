#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "formats/toolpath/gcode_words.h"

namespace t4d::formats {

/// The modal groups of G words: words of one group exclude each other in a line.
enum class GcodeGroup : std::uint8_t {
  Motion,    ///< G0 to G3, canned cycles
  Cancel,    ///< G80
  NonModal,  ///< G4, G10, G28, G30, G52, G53, G92
  Plane,
  Units,
  Distance,
  Centres,
  Origin,
  FeedMode,
  Retract,     ///< G98, G99
  ToolLength,  ///< G43, G49
  Path,        ///< G61, G64
  Harmless,    ///< G40, G97; may come together
};
inline constexpr std::size_t kGcodeGroups = 13;

/// The words of a line. G words are counted in tenths, as in 592 for G59.2.
struct GcodeBlock {
  std::array<std::optional<int>, kGcodeGroups> codes = {};
  std::array<std::optional<double>, 6> axes = {};    ///< X Y Z A B C
  std::array<std::optional<double>, 3> centre = {};  ///< I J K
  std::optional<double> f = {}, h = {}, l = {}, p = {}, q = {}, r = {}, t = {};
  bool changesTool = false;  ///< M6
  bool namesTool = false;    ///< M61
  bool calls = false;        ///< M98
  bool returns = false;      ///< M99
  bool ends = false;         ///< M2, M30

  std::optional<int> code(GcodeGroup group) const { return codes[static_cast<std::size_t>(group)]; }
  bool hasAxes() const;
  bool hasCentre() const { return centre != GcodeBlock{}.centre; }
};

/// "G59.2" of 592.
std::string gcodeWord(int tenths);

/// Reads the words of a line without N and O, sets the parameters that it assigns to after all of
/// them have been read, and refuses words that are not known.
Result<GcodeBlock> readGcodeBlock(std::string_view text, GcodeParameters& parameters);

}  // namespace t4d::formats
