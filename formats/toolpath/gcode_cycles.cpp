#include "formats/toolpath/gcode_cycles.h"

#include <fmt/format.h>

#include "t4d/motion.h"

namespace t4d::formats {
namespace {

// LinuxCNC's: ten thousandths of an inch.
constexpr double kDrawnBack = 0.254;

using Move = std::function<Result<void>(double, bool)>;

Result<void> peck(const CycleHole& hole, const Move& move) {
  if (!((hole.clear - hole.bottom) / hole.peck < static_cast<double>(model::kMaxSegments))) {
    return invalid(fmt::format("a hole of {:g} in steps of Q = {:g} has too many of them",
                               hole.clear - hole.bottom, hole.peck));
  }
  for (double depth = hole.clear - hole.peck; depth > hole.bottom; depth -= hole.peck) {
    if (auto done = move(depth, false); !done) return done;
    if (hole.code == 830) {
      if (auto done = move(hole.clear, true); !done) return done;
    }
    if (auto done = move(depth + kDrawnBack, true); !done) return done;
  }
  return move(hole.bottom, false);
}

}  // namespace

Result<void> visitCycle(const CycleHole& hole, const Move& move) {
  const bool pecks = hole.code == 730 || hole.code == 830;
  if (auto done = pecks ? peck(hole, move) : move(hole.bottom, false); !done) return done;
  const bool feedsBack =
      hole.code == 740 || hole.code == 840 || hole.code == 850 || hole.code == 890;
  if (!feedsBack) return move(hole.retract, true);
  return move(hole.retract, false);
}

}  // namespace t4d::formats
