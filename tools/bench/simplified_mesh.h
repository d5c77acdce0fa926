#pragma once

#include <filesystem>

#include "t4d/error.h"
#include "tools/bench/report.h"

namespace t4d::bench {

/// Measures how long a collapse takes in a woven ball (edit::simplify to a tenth, on one thread),
/// against one of meshoptimizer and of PyPI's fast-simplification, where this is installed, in a
/// sphere of as many triangles as the ball has cells; and what a proved error and a second thread
/// cost.
Result<void> measureSimplifiedMesh(const std::filesystem::path& folder, Report& report);

}  // namespace t4d::bench
