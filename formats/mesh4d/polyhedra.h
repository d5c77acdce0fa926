#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "formats/mesh4d/mesh4d_builder.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// Polyhedra that list faces, which list corners, and the tetrahedra that they are made of.
class Polyhedra {
 public:
  /// The corners of a polygon in order around it, at least three.
  void addFace(std::span<const std::uint32_t> corners);

  /// The faces of a polyhedron, at least four, by their numbers.
  void addCell(std::span<const std::uint32_t> faces);

  std::size_t faceCount() const { return faceBegin_.size() - 1; }

  /// Adds the tetrahedra of all cells to a mesh that has the vertices, and returns what is to be
  /// said about them; "" if all cells are tetrahedra.
  ///
  /// Four triangles of four vertices are one tetrahedron, whose corner i is opposite face i. Other
  /// polyhedra are pulled (polyhedron.h). Where this would give a triangle to more than two
  /// tetrahedra, as in star polytopes, whose faces cross and have corners in common, every cell is
  /// split from its centre: that is joined to the centre of each face and each edge of this face.
  Result<std::string> addTo(Mesh4dBuilder& mesh) const;

 private:
  std::span<const std::uint32_t> face(std::size_t i) const;
  std::span<const std::uint32_t> cell(std::size_t i) const;
  std::size_t cellCount() const { return cellBegin_.size() - 1; }
  std::size_t pull(std::vector<model::Cell>& tetrahedra) const;
  Result<std::vector<model::Cell>> splitFromCentres(Mesh4dBuilder& mesh) const;

  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> faceBegin_ = {0};
  std::vector<std::uint32_t> faces_;
  std::vector<std::size_t> cellBegin_ = {0};
};

}  // namespace t4d::formats
