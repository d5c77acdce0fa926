#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "t4d/model/triangle_mesh.h"

/// Pictures of solids by a small software renderer: no window, no graphics card, the same pixels
/// everywhere.
namespace t4d::tools {

using Colour = std::array<float, 3>;  ///< red, green, blue, from 0 to 1

/// Looks at solids from the front, a little from above and from the side, without perspective.
struct View {
  model::Point3 middle = model::Point3::Zero();  ///< is in the middle of the picture
  double extent = 1;                             ///< length units across the picture, both ways
  bool zUp = false;                              ///< the z axis points up, instead of y
};

/// A view whose picture holds everything within `bounds`.
View viewOf(const model::Bounds3& bounds, bool zUp);

/// What colour a point of a surface has, asked for once for each pixel that shows it.
using ColourAt = std::function<Colour(const model::Point3&)>;

enum class Shading : std::uint8_t {
  Solid,  ///< flat, with the edges of triangles that are large enough for that
  Faint,  ///< so that colours can still be read off
};

/// A square picture with transparent background as the bytes of a PNG file.
std::vector<std::uint8_t> pictureOf(const model::TriangleMesh& mesh, const ColourAt& colourAt,
                                    const View& view, std::uint32_t pixels,
                                    Shading shading = Shading::Solid);

}  // namespace t4d::tools
