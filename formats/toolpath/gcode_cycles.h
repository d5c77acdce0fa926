#pragma once

#include <functional>

#include "t4d/error.h"

namespace t4d::formats {

/// A hole of a canned cycle, along the axis of its plane, in mm. All heights are above `bottom`.
struct CycleHole {
  int code = 810;      ///< of the cycle: 730, 740, 810 to 860, 890
  double clear = 0;    ///< R: where feed begins
  double bottom = 0;   ///< Z
  double retract = 0;  ///< where it ends: R, or higher
  double peck = 0;     ///< Q, of G73 and G83
};

/// Visits the moves of a hole after the tool has come to its clear height, as LinuxCNC makes them:
/// feed to the bottom (in pecks for G73, which draws back by 0.254 mm, and for G83, which draws
/// back to R), then back, by a rapid move, or by feed for G74, G84, G85 and G89. Fails for more
/// pecks than a motion can have.
Result<void> visitCycle(const CycleHole& hole,
                        const std::function<Result<void>(double height, bool rapid)>& move);

}  // namespace t4d::formats
