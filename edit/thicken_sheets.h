#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "edit/mend_steps.h"

/// Sheets: open surfaces that enclose nothing when their holes are filled.
namespace t4d::edit {

/// A surface whose sheets have two sides, sewn together at the rim. Its vertices are those of
/// `origins`, and then those on the other side of the ones in `sheet`, in this order.
struct ThickSheets {
  model::TriangleMesh mesh = {};
  std::vector<VertexOrigin> origins = {};  ///< by the vertices before
  std::vector<std::uint32_t> sheet = {};
  std::vector<model::Triangle> triangles = {};  ///< of the sheets, by `origins`
};

/// How many sheets there are: connected parts that are open, no larger than twice the area that
/// closes their rim, and would cross themselves or be flat if holes were filled. 0 in a build
/// without CGAL.
Result<std::size_t> countSheets(const model::TriangleMesh& mesh);

/// Gives the sheets of a surface a thickness, in the unit that `scale` is from. Where they touch
/// others they get vertices of their own. Nothing if there are no sheets.
Result<std::optional<ThickSheets>> thickSheetsOf(const model::TriangleMesh& mesh, double thickness,
                                                 const model::UnitScale& scale, Changes& changes);

/// Moves the vertices in `sheet` by half the thickness along their normals, by the areas of the
/// triangles around them, and puts the last vertices, one for each, on the other side.
void placeSides(std::span<model::Point3> places, std::span<const model::Triangle> triangles,
                std::span<const std::uint32_t> sheet, double thickness);

}  // namespace t4d::edit
