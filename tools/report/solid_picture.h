#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "t4d/model/triangle_mesh.h"

/// Renders pictures of solids in software: no window, no graphics card, the same pixels on every
/// machine.
namespace t4d::tools {

using Colour = std::array<float, 3>;  ///< red, green, blue, from 0 to 1

/// An orthographic view of solids from the front, slightly from above and from the side.
struct View {
  model::Point3 middle = model::Point3::Zero();  ///< shown in the middle of the picture
  double extent = 1;  ///< length units across the picture, in both directions
  bool zUp = false;   ///< the z axis points up, instead of y
};

/// A view whose picture contains everything within `bounds`.
View viewOf(const model::Bounds3& bounds, bool zUp);

/// Adds the triangles of another mesh, for a picture of both.
void append(model::TriangleMesh& to, const model::TriangleMesh& mesh);

/// The colour of a point of a surface; called once for each pixel that shows it.
using ColourAt = std::function<Colour(const model::Point3&)>;

enum class Shading : std::uint8_t {
  Solid,  ///< lit from one side
  Faint,  ///< lit little, so that colours can be read
};

/// Whether most of a surface consists of triangles large enough for their edges to be drawn in such
/// a picture; true for an empty one.
bool showsEdges(const model::TriangleMesh& mesh, const View& view, std::uint32_t pixels);

/// A square picture with transparent background as the bytes of a PNG file, flat shaded. With
/// `edges`, the edges of triangles that are large enough are drawn.
std::vector<std::uint8_t> pictureOf(const model::TriangleMesh& mesh, const ColourAt& colourAt,
                                    const View& view, std::uint32_t pixels, Shading shading,
                                    bool edges);

}  // namespace t4d::tools
