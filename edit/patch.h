#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "edit/quadric4.h"
#include "t4d/mesh.h"

namespace t4d::edit {

/// A point of the mesh that a patch is made from, and the cell of the patch that is near it in the
/// slice at the time of the point.
struct Sample {
  model::Point4 point;
  std::uint32_t cell;
};

/// Consecutive slabs of a 4D mesh, joined for simplification: a slab whose times are lengths, with
/// data about the original mesh for each vertex. One made by `joined` has a seam, the layer between
/// its two parts:
///
///     vertices   lower layer | interior | seam | interior | upper layer
///     cells      those of the first part | those of the second
struct Patch {
  double timeBegin = 0;
  double timeEnd = 0;
  std::uint32_t lowerCount = 0;
  std::uint32_t upperCount = 0;
  std::uint32_t seamBegin = 0;    ///< first vertex of the seam
  std::uint32_t seamEnd = 0;      ///< one more than the last; seamBegin without a seam
  std::uint32_t cellsBefore = 0;  ///< number of cells of the first part; 0 without a seam
  std::vector<model::Point4> vertices = {};
  std::vector<model::Cell> cells = {};
  std::vector<model::Attribute> attributes = {};  ///< one row for each vertex or cell
  std::vector<Quadric4> quadrics = {};            ///< one for each vertex, relative to it
  /// For each vertex, how far samples may be from the cells around it when it moves. A vertex with
  /// a negative reach does not move.
  std::vector<double> reaches = {};
  std::vector<Sample> samples = {};

  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(vertices.size()); }
  std::uint32_t firstUpper() const { return vertexCount() - upperCount; }
  bool isInLayer(std::uint32_t vertex) const {
    return vertex < lowerCount || vertex >= firstUpper();
  }
  bool isInSeam(std::uint32_t vertex) const { return vertex >= seamBegin && vertex < seamEnd; }
  /// Makes the vertices of the seam interior ones.
  void forgetSeam() { seamBegin = seamEnd = cellsBefore = 0; }
};

/// Makes a patch of consecutive slabs; times become lengths by `timeScale`. The quadrics are those
/// of the cells, weighted by volume; there are no samples, and reaches are unlimited. All slabs
/// must have the same attributes. Fails if the layers of two slabs differ in size.
Result<Patch> patchOf(std::span<const std::shared_ptr<const model::Slab>> slabs, double timeScale);

/// Joins two consecutive patches that share a layer, with a seam there.
Patch joined(Patch lower, const Patch& upper);

/// The two parts of a patch with a seam.
struct PatchPair {
  Patch lower;
  Patch upper;
};
PatchPair parted(const Patch& whole);

/// Keeps only these vertices and cells of a patch, in increasing order. The cells must have only
/// these vertices.
void selectFrom(Patch& patch, std::span<const std::uint32_t> vertices,
                std::span<const std::uint32_t> cells);

/// Makes a slab of a patch without a seam; lengths become times by `timeScale`.
model::Slab slabOf(Patch patch, double timeScale);

}  // namespace t4d::edit
