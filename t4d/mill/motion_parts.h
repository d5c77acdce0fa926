#pragma once

#include <vector>

#include "t4d/model/motion.h"
#include "t4d/model/times.h"

namespace t4d::mill {

/// The part of a motion within `span`, which lies within it, cut further such that the origin of
/// the moving frame goes at most `travel` between cuts. Poses are those of the motion, but for
/// rounding.
model::Motion partOf(const model::Motion& motion, const model::TimeSpan& span, double travel);

/// When the origin of the moving frame has gone `travel` farther than at `time`; at the latest the
/// end of the motion.
double timeAfterTravel(const model::Motion& motion, double time, double travel);

}  // namespace t4d::mill
