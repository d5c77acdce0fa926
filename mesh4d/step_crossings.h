#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {

/// Searches a step for triangles that meet while their corners move along straight lines from the
/// lower layer to the upper one. Returns nothing if none do. The first pair is the one with the
/// earliest time.
///
/// Whether two triangles meet can change only when a corner of one is in the plane of the other, or
/// when two of their sides are in one plane: at the roots of cubics in time. Between any two such
/// times that are more than 1e-7 of the step apart, the triangles are tested once, by exact
/// predicates on positions rounded to doubles. Triangles with a common side meet when one swings
/// through the other. Reported triangles do meet, up to rounding. Unreported ones may meet for less
/// than this time, or by less than rounding, or slide into each other in a plane in which both
/// stay. Triangles that only touch count.
///
/// Pairs are those whose boxes meet, swept over parts of the step, from which the mean motion has
/// been subtracted. The search ends after kMostSweptPairs pairs. Runs on all threads; the result
/// does not depend on their number. Only in a build with CGAL.
Result<std::optional<StepCrossing>> crossingOf(const model::TriangleMesh& mesh,
                                               const model::Slab& step);

inline constexpr std::uint64_t kMostSweptPairs = 30'000'000;

}  // namespace t4d::mesh4d
