#pragma once

#include "t4d/formats/gltf/gltf_animation.h"

namespace t4d::formats {

/// USD, text or a package of it.
std::vector<system::FileFormat> animatedUsdFormats();

/// True for the name of a file that may be an animated USD: .usda, .usdz, .usd, .usdc.
bool isAnimatedUsd(const std::filesystem::path& path);

/// Reads an animation of USD text or of a package of it, over the time that is played, in seconds:
/// each Mesh prim is a body, moved by time samples of its points and by its xformOps and those of
/// its parents. Of `options`, the tolerance, in the unit of the file, and the edge factor are used.
///
/// Layers are at all samples that move a body, and between them such that slices are within the
/// tolerance, as readGltfAnimation has them. A body is left out for as long as it is invisible. One
/// whose transform mirrors is read mirrored. Faces must be the same at all times.
Result<AnimatedScene> readUsdAnimation(InputFile file, const GltfAnimationOptions& options);

}  // namespace t4d::formats
