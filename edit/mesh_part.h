#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/surface.h"

namespace t4d::edit {

/// A part of a mesh, and its vertices by their numbers there.
struct MeshPart {
  model::TriangleMesh mesh = {};
  std::vector<std::uint32_t> vertices = {};
};

/// Some triangles of a mesh, in this order, with vertices of their own. Attributes come along.
MeshPart partOf(const model::TriangleMesh& mesh, std::span<const std::uint32_t> triangles);

}  // namespace t4d::edit
