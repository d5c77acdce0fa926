#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

/// Tools that are solids of revolution about z, with the tip at the origin and the shank upward.
namespace t4d::mill {

enum class ToolKind : std::uint8_t {
  Ball,  ///< a half ball below a cylinder
  Flat,  ///< a cylinder
  Bull,  ///< a cylinder with a rounded lower edge
};

struct ToolShape {
  ToolKind kind = ToolKind::Ball;
  double diameter = 0;
  double cornerRadius = 0;  ///< of Bull: below half the diameter
  double length = 0;        ///< along z
};

/// Reads `ball:d=6,l=30`, `flat:d=6,l=30` or `bull:d=6,r=1,l=30`. Fails for other words, sizes that
/// are missing or not above zero, and a tool that is shorter than its rounding.
Result<ToolShape> parseTool(std::string_view text);

/// A cylinder, as a shank or a holder.
struct Cylinder {
  double diameter = 0;
  double length = 0;
};

/// Reads `d=40,l=50`.
Result<Cylinder> parseCylinder(std::string_view text);

/// The tool as a closed triangle mesh with its vertices on the tool and no point of the tool
/// farther than `tolerance` from it. Its volume is smaller than the tool's, by the order of the
/// tolerance.
model::TriangleMesh toolMesh(const ToolShape& tool, double tolerance);

/// The same of a cylinder that begins at the height `from`.
model::TriangleMesh cylinderMesh(const Cylinder& cylinder, double from, double tolerance);

}  // namespace t4d::mill
