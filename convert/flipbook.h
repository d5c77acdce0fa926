#pragma once

#include <span>

#include "t4d/convert.h"

namespace t4d::convert {

/// The first check of every kind of flipbook. Fails if checkFrameTimes does, and for a rate that is
/// not positive and finite.
Result<void> checkFlipbook(std::span<const model::Body> bodies, std::span<const double> times,
                           const FlipbookOptions& options);

}  // namespace t4d::convert
