#pragma once

#include <filesystem>
#include <span>

#include "t4d/convert/flipbook.h"
#include "t4d/model/body.h"

namespace t4d::convert {

/// A flipbook whose bodies are one mesh each, with a morph target for each layer of the 4D mesh, or
/// in USD a sample of its points: `times` says only the first and last time to show and how long it
/// plays, as writeFlipbook does with a frame for each. Light slices between two layers are (1 - s)
/// P + s Q (slice::LightSlicer), which is what linear weights of two targets make of them: so it
/// shows the light slice at every moment, not only at frames, up to float32.
///
/// A body must consist of prisms of the same triangles, without a gap in time: a sweep of any
/// motion or deformation does. `options.detail` is not used, nor are attributes, and colours
/// are those of the first time. Fails as writeFlipbook, and for a body of another kind, saying at
/// which time and why.
Result<FrameSlicesReport> writeMorphFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options = {},
                                             const model::Progress& progress = {});

}  // namespace t4d::convert
