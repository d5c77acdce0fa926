#pragma once

#include "t4d/error.h"
#include "tools/bench/report.h"

namespace t4d::bench {

/// Times measure::collideAll on all pairs of an arm of six links with twenty obstacles: against
/// FCL's continuous collision of each pair, and against measure::collide of each pair alone.
Result<void> measureArmAndObstacles(Report& report);

}  // namespace t4d::bench
