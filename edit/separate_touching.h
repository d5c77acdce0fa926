#pragma once

#include <cstdint>
#include <vector>

#include "edit/split_cells.h"
#include "t4d/mesh.h"

namespace t4d::edit {

/// Separates what touches at one time in cells that end there: after it, the cells around each edge
/// and around each vertex at that time are connected by triangles.
///
///        \ | /   time      \ | | /
///         \|/    --->       \| |/     the section of a solid that splits there, which touches
///         /|\               /| |\     itself, becomes a surface
///
/// Where the cells around an edge are several fans, each gets a vertex of its own in the middle of
/// the edge, at one place; where those around a vertex are, each but one gets a copy of it. New
/// vertices are added by `splitter`. `cellOf` has a value for each cell, which its parts take over.
void separateTouching(double time, std::vector<model::Point4>& vertices, CellSplitter& splitter,
                      std::vector<model::Cell>& cells, std::vector<std::uint32_t>& cellOf);

}  // namespace t4d::edit
