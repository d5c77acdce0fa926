#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {

/// The connectivity of one step of a closed triangle mesh of V vertices, E edges and F triangles:
/// the lower layer (V), for Fourteen the centroids of the quadrilaterals (E) and of the prisms (F)
/// as means, and the upper layer (V); 14 F or 3 F cells. All steps of a sweep share it.
///
///          b0 ------- b2
///          |\ \     / /|        an outward-facing triangle (a0, a1, a2) at the start of a step,
///          | \ \   / / |        (b0, b1, b2) the same triangle at its end;
///          |  \  b1 /  |        q01, q12, q20: centroids of the quadrilaterals;
///          | q01 | q12 |        g: centroid of the prism.
///          |    \|/    |
///          a0 ---|---- a2       14 cells, all with apex g, over: the triangle below, the one above
///            \   |   /          and the four triangles around each of the three q's.
///              \ | /
///                a1
///
/// Attributes of the cells: "triangle" (UInt32, the input triangle), "kind" (UInt8, CellKind) and
/// those of the mesh, inputAttributes.
std::shared_ptr<const model::Connectivity> stepConnectivity(const model::TriangleMesh& mesh,
                                                            PrismSplit split);

/// The attributes that every cell of a swept mesh has.
std::vector<model::Attribute> cellAttributes(const std::vector<std::uint32_t>& triangles,
                                             const std::vector<std::uint8_t>& kinds);

/// The attributes of a mesh, for cells that come from these triangles of it: its triangle
/// attributes, and its vertex attributes as corner attributes (model::kCornersOf), except
/// "triangle" and "kind". Zero if the triangle is kNoTriangle.
std::vector<model::Attribute> inputAttributes(const model::TriangleMesh& mesh,
                                              const std::vector<std::uint32_t>& triangles);

}  // namespace t4d::mesh4d
