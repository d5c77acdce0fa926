#pragma once

#include <filesystem>
#include <span>

#include "convert/flipbook.h"
#include "model/body.h"

namespace t4d::convert {

/// Writes a flipbook with one mesh per body, with a morph target (in USD a sample of the points)
/// for each layer of the 4D mesh. `times` determines only the first and last time to show and how
/// long it plays: as long as writeFlipbook with these frames. Light slices between two layers are
/// (1 - s) P + s Q (slice::LightSlicer), and so are meshes with linear weights of two targets. So
/// the flipbook shows the light slice at every moment, not only at frames, in float32.
///
/// A body must consist of prisms of the same triangles, without a gap in time, as a sweep of any
/// motion or deformation does. `options.detail` is not used, and colours and attributes are those
/// of the first time (addFirstLooks). Fails if writeFlipbook does, and for any other body, with the
/// time and the reason.
Result<FrameSlicesReport> writeMorphFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options = {},
                                             const model::Progress& progress = {});

}  // namespace t4d::convert
