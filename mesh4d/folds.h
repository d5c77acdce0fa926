#pragma once

#include <cstdint>
#include <optional>

#include "mesh4d/prism.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {

/// Searches for folded prisms in a step made with stepConnectivity(mesh). Returns nothing if there
/// are none.
///
/// A prism is folded if one of its cells faces away from the mean direction n of its triangle
/// during the step: det[n, b-a, c-a, d-a] <= 0, where n is the integral over the step of the
/// interpolated triangle's area vector. If no prism is folded, then in every slice all pieces of
/// every triangle face the same side as the triangle does on average: none is inside out and none
/// has collapsed. Different prisms may still cross each other.
///
/// Positions are rounded. A sign that rounding can change says nothing of a triangle that is so
/// narrow in both layers that it has no direction: a sliver of a solid that rests or only moves
/// does not fold.
std::optional<Fold> foldOf(const model::TriangleMesh& mesh, const model::Slab& step);

/// True if a step from one pose to another turns no solid over, whatever its triangles: the
/// positions between the two, (1 - s) P + s Q, are images under an affine map whose determinant is
/// a cubic in s. It has one sign if its four Bernstein coefficients have. A rest, a translation and
/// a turn by up to 120 degrees fold nowhere, nor does scaling.
bool foldsNowhere(const model::Affine3x4& from, const model::Affine3x4& to);

}  // namespace t4d::mesh4d
