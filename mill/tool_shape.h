#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "t4d/error.h"
#include "t4d/surface.h"

/// Tools that are solids of revolution about z, with the tip at the origin and the shank upward.
namespace t4d::mill {

enum class ToolKind : std::uint8_t {
  Ball,   ///< a half ball below a cylinder
  Flat,   ///< a cylinder
  Bull,   ///< a cylinder with a rounded lower edge
  Cone,   ///< a cone below a cylinder: drills, V-bits and chamfer tools
  Taper,  ///< a cone that widens upward, with a flat or a round lower end
};

struct ToolShape {
  ToolKind kind = ToolKind::Ball;
  double diameter = 0;  ///< of Taper: of its flat lower end, or 0
  double cornerRadius =
      0;              ///< of Bull: below half the diameter; of Taper: of its round lower end, or 0
  double length = 0;  ///< along z
  double angle = 0;   ///< degrees; of Cone between its sides, of Taper between side and axis
  double tipDiameter = 0;  ///< of Cone: of its flat lower end
};

/// Reads `ball:d=6,l=30`, `flat:d=6,l=30`, `bull:d=6,r=1,l=30`, `drill:d=6,a=118,l=60` (without a
/// and l: 118 degrees and ten diameters), `vbit:d=6,a=60,t=0.2,l=20` and
/// `chamfer:d=10,a=90,t=2,l=20` (without t: a sharp tip), `taper:d=2,a=5,l=30` and
/// `taper:r=1,a=5,l=30`. Fails for other words, sizes that are missing, not above zero or do not
/// fit each other, and a tool that is shorter than its rounding or its cone.
Result<ToolShape> parseTool(std::string_view text);

/// Whether a text is meant for parseTool, and not the name of a file.
bool namesToolKind(std::string_view text);

/// A cylinder, as a shank or a holder.
struct Cylinder {
  double diameter = 0;
  double length = 0;
};

/// Reads `d=40,l=50`.
Result<Cylinder> parseCylinder(std::string_view text);

/// The most triangles of a tool.
inline constexpr std::uint64_t kMostToolTriangles = 10'000'000;

/// The tool as a closed triangle mesh with its vertices on the tool and no point of the tool
/// farther than `tolerance` from it. Its volume is smaller than the tool's, by the order of the
/// tolerance. Fails for a tolerance that needs more than kMostToolTriangles, with one that does
/// not.
Result<model::TriangleMesh> toolMesh(const ToolShape& tool, double tolerance);

/// A cylinder that begins at the height `from`, as a closed triangle mesh like toolMesh.
Result<model::TriangleMesh> cylinderMesh(const Cylinder& cylinder, double from, double tolerance);

}  // namespace t4d::mill
