#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/surface.h"

namespace t4d::edit {

/// The attributes of a mesh for another one that was made of its triangles, turned or not: vertex i
/// of `after` follows the vertex `sources[i]`. A triangle that is not one of `before` has at each
/// corner what some triangle has there, and else what such a triangle of its first corner has.
std::vector<model::Attribute> carriedAttributes(const model::TriangleMesh& before,
                                                std::span<const model::Triangle> after,
                                                std::span<const std::uint32_t> sources);

}  // namespace t4d::edit
