#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "t4d/model/error.h"
#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::mesh4d {

/// Where the surface crosses itself within one step.
struct StepCrossing {
  model::TimeSpan time;     ///< of the step
  std::uint64_t pairs = 0;  ///< of triangles that meet at some time of the step
  bool complete = true;     ///< false if the search ended early
  double at = 0;            ///< a time when the first of them meet
  std::array<std::uint32_t, 2> triangles = {0, 0};  ///< of the first, the smaller number first
  model::Point3 place;                              ///< about where these meet then
};

/// Searches a step for triangles that meet while their corners go straight from the lower layer to
/// the upper one; nothing if none do. First is the pair with the earliest time.
///
/// Whether two triangles meet can change only when a corner of one is in the plane of the other, or
/// when two of their sides are in one plane: at the roots of cubics in time. Between any two such
/// times that are not within 1e-7 of the step of each other, the triangles are looked at once, by
/// exact predicates on places rounded to doubles. Triangles with a common side meet when one swings
/// through the other. So what is reported does meet, up to rounding; what is not, meets at most for
/// such a short time, by less than rounding, or slides into each other in a plane in which both
/// stay. Triangles that only touch count.
///
/// Pairs are those whose boxes meet, swept over parts of the step, from which the mean motion has
/// been subtracted. Time grows with their number; after kMostSweptPairs the search ends. Runs on
/// all threads; the result does not depend on their number. Only in a build with CGAL.
Result<std::optional<StepCrossing>> crossingOf(const model::TriangleMesh& mesh,
                                               const model::Slab& step);

inline constexpr std::uint64_t kMostSweptPairs = 30'000'000;

}  // namespace t4d::mesh4d
