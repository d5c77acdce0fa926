#pragma once

#include <array>
#include <string>

#include <fmt/format.h>

namespace t4d::tools {

/// A box as .obj. Its faces count vertices backward, so that one file can have several.
inline std::string boxText(const std::array<double, 3>& low, const std::array<double, 3>& high) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += fmt::format("v {} {} {}\n", (i & 1) != 0 ? high[0] : low[0],
                        (i & 2) != 0 ? high[1] : low[1], (i & 4) != 0 ? high[2] : low[2]);
  }
  return text +
         "f -8 -6 -5 -7\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -2 -1 -5\nf -8 -4 -2 -6\n"
         "f -7 -5 -1 -3\n";
}

}  // namespace t4d::tools
