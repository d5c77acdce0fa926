#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "t4d/convert.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/slice_write_options.h"

namespace t4d::tools {

/// Begins a colour that is followed by the name of an attribute.
inline constexpr std::string_view kColorByAttribute = "attribute:";

/// The smallest and largest value of what gives colours: the ends of the colour map.
using ColorRange = std::array<double, 2>;

/// The source of the colours of slices.
struct Painting {
  convert::Paint paint = {};             ///< null if no colours are asked for
  std::optional<ColorRange> range = {};  ///< if they come from numbers
};

/// Colours by the attribute `velocity`, from a speed of 0 to the largest.
Painting paintingBySpeed(double largest);

/// Colours by track (measure::tracksOf), each in that of the lineage picture, of exact slices at
/// these times; adds the attribute `track` to triangles. What is not of a track is grey.
Result<Painting> paintingByTrack(const Input& input, std::span<const double> times,
                                 Observer& observer);

/// Colours of the bodies of an input, by their attributes over the range of all bodies or of these
/// meshes. Not by speed or track. Fails as convert::attributeColors does.
Result<Painting> paintingOf(const SliceWriteOptions& options, const Input& input);
Result<Painting> paintingOf(const SliceWriteOptions& options, const Input& input,
                            std::span<const formats::NamedMesh> meshes);

/// Colours of frames, by speed and by track too: for that the mesh is read once more.
Result<Painting> paintingOfFrames(const SliceWriteOptions& options, const Input& input,
                                  std::span<const double> times, slice::SliceDetail detail,
                                  const std::optional<convert::FrameVelocity>& velocity,
                                  Observer& observer);

}  // namespace t4d::tools
