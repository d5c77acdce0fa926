#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "t4d/surface.h"

/// Renders pictures of solids in software: no window, no graphics card, the same pixels on every
/// machine.
namespace t4d::tools {

using Colour = std::array<float, 3>;  ///< red, green, blue, from 0 to 1

constexpr Colour kBlue = {0.55F, 0.71F, 0.90F};
constexpr Colour kOrange = {0.95F, 0.72F, 0.50F};
constexpr Colour kRed = {0.90F, 0.36F, 0.20F};
constexpr Colour kGrey = {0.72F, 0.74F, 0.78F};

/// A colour between `from` at 0 and below, and `to` at 1 and above.
Colour blended(const Colour& from, const Colour& to, double part);

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
ColourAt always(const Colour& colour);

enum class Shading : std::uint8_t {
  Solid,  ///< lit from one side
  Faint,  ///< lit little, so that colours can be read
};

/// A figure for a page (html_page.h): a square picture with transparent background, flat shaded,
/// and its caption. If most of the surface consists of large triangles, their edges are drawn.
std::string figureOf(const model::TriangleMesh& mesh, const ColourAt& colourAt, const View& view,
                     const std::string& caption, Shading shading = Shading::Solid);

}  // namespace t4d::tools
