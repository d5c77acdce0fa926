#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "t4d/edit/quadric4.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

/// A point of the mesh that a patch is made from, and the cell of the patch that is near to it: in
/// the slice at the time of the point.
struct Sample {
  model::Point4 point;
  std::uint32_t cell;
};

/// Consecutive slabs of a 4D mesh put together, as they are simplified: a slab whose times are
/// lengths, with what its vertices remember of the mesh that they come from. One made by `joined`
/// has a seam, the layer between its two parts:
///
///     vertices   lower layer | interior | seam | interior | upper layer
///     cells      those of the first part | those of the second
struct Patch {
  double timeBegin = 0;
  double timeEnd = 0;
  std::uint32_t lowerCount = 0;
  std::uint32_t upperCount = 0;
  std::uint32_t seamBegin = 0;    ///< of the vertices of the seam
  std::uint32_t seamEnd = 0;      ///< one more than the last; seamBegin without a seam
  std::uint32_t cellsBefore = 0;  ///< of the first part; 0 without a seam
  std::vector<model::Point4> vertices = {};
  std::vector<model::Cell> cells = {};
  std::vector<model::Attribute> attributes = {};  ///< one row for each vertex or cell
  std::vector<Quadric4> quadrics = {};            ///< one for each vertex, about it
  /// How far samples may be from the cells around each vertex, when it moves; below 0 it stays.
  std::vector<double> reaches = {};
  std::vector<Sample> samples = {};

  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(vertices.size()); }
  std::uint32_t firstUpper() const { return vertexCount() - upperCount; }
  bool isInLayer(std::uint32_t vertex) const {
    return vertex < lowerCount || vertex >= firstUpper();
  }
  bool isInSeam(std::uint32_t vertex) const { return vertex >= seamBegin && vertex < seamEnd; }
};

/// Slabs that follow one another, as one patch; times become lengths by `timeScale`. The quadrics
/// are those of the cells, weighted by volume; there are no samples, and reaches have no limit. All
/// slabs must have the same attributes. Fails if the layers of two slabs differ in size.
Result<Patch> patchOf(std::span<const std::shared_ptr<const model::Slab>> slabs, double timeScale);

/// Two patches that follow one another and share a layer as one, with a seam there.
Patch joined(Patch lower, const Patch& upper);

/// The parts of a patch with a seam.
struct PatchPair {
  Patch lower;
  Patch upper;
};
PatchPair parted(const Patch& whole);

/// Keeps these vertices and cells of a patch, which increase. Cells have only such vertices.
void selectFrom(Patch& patch, std::span<const std::uint32_t> vertices,
                std::span<const std::uint32_t> cells);

/// A patch without a seam as a slab; lengths become times by `timeScale`.
model::Slab slabOf(Patch patch, double timeScale);

}  // namespace t4d::edit
