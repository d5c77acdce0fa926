#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"

namespace t4d::mill {

/// Where something may be that is to be looked at: whether a ball can meet it.
using Near = std::function<bool(const model::Point3& center, double radius)>;

/// Calls `take` with the parts of a motion within `span`, which lies within it, in order, that come
/// near enough to something. Parts are such that the origin of the moving frame goes at most
/// `travel` in each, and one that stays within a ball about that origin, of radius `reach` more
/// than the way, is left out if `near` is false for the ball. Consecutive parts come together, at
/// most kMostParts at once, as the segments of one motion. Poses are those of the motion, but for
/// rounding. Stops at the first error of `take`.
///
/// The time is that of the parts taken, however far the motion goes elsewhere, and of those that go
/// round what is near without coming to it. Fails after kMostLooks parts of all sizes.
Result<void> visitParts(const model::Motion& motion, const model::TimeSpan& span, double travel,
                        double reach, const Near& near,
                        const std::function<Result<void>(const model::Motion&)>& take);

inline constexpr std::size_t kMostParts = 1000;
inline constexpr std::uint64_t kMostLooks = 30'000'000;

/// When the origin of the moving frame has gone `travel` farther than at `time`; at the latest the
/// end of the motion.
double timeAfterTravel(const model::Motion& motion, double time, double travel);

}  // namespace t4d::mill
