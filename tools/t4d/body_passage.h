#pragma once

#include "edit/clip_time.h"
#include "tools/t4d/time_window.h"

namespace t4d::tools {

/// Puts the part of a body within the span, that of the window, into a sink.
Result<void> putWithin(const model::Body& body, const TimeWindow& window,
                       const model::TimeSpan& span, model::Sink& sink,
                       const model::Progress& progress);

}  // namespace t4d::tools
