#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "t4d/file.h"

namespace t4d::formats {

/// Checks the vertices and tetrahedra of a file and makes bodies of them.
class Mesh4dBuilder {
 public:
  /// The position of a cell or vertex in the file; `PlaceOf` turns it into the `where` of an error.
  using Position = std::uint64_t;
  using PlaceOf = std::function<Place(Position)>;

  /// `firstIndex` is how the format counts vertices, for messages: from 0 or from 1.
  Mesh4dBuilder(Place file, PlaceOf placeOf, unsigned firstIndex = 0)
      : file_(std::move(file)), placeOf_(std::move(placeOf)), firstIndex_(firstIndex) {}

  /// Reserves memory; the caller has checked the counts against the size of the file.
  void reserve(std::size_t vertices, std::size_t cells);

  /// Coordinates that are not finite, or beyond model::kLargestCoordinate, are an error.
  Result<void> addVertex(const model::Point4& vertex, Position position);

  /// `corners` are the numbers of vertices, from 0, which may follow later. `part` is what the
  /// format groups cells by: a reference, a region, a physical group.
  Result<void> addCell(const std::array<std::uint64_t, 4>& corners, std::int64_t part,
                       Position position);

  /// Adds all at once; the position of an error is the number of the vertex.
  Result<void> addVertices(std::vector<model::Point4> vertices);

  /// Adds all at once, with `first` added to each corner. `parts` has one for each cell, or is
  /// empty if there are none. The position of an error is the number of the cell.
  Result<void> addCells(std::vector<model::Cell> cells, std::size_t first,
                        std::span<const std::int64_t> parts);

  /// Attributes with a row for each vertex and each cell added, dropped ones included.
  void setAttributes(std::vector<model::Attribute> attributes) {
    attributes_ = std::move(attributes);
  }

  std::size_t vertexCount() const { return vertices_.size(); }
  std::span<model::Point4> vertices() { return vertices_; }

  /// Drops cells with equal corners and vertices without cells, with a notice. Parts become bodies
  /// with these names if each is closed by itself; otherwise they are parts of the boundary of one
  /// solid, and become one body, with a notice.
  ///
  /// Fails on an index out of range, and when no cell is left.
  Result<LoadedMesh4d> finish(const std::map<std::int64_t, std::string>& names = {}) &&;

 private:
  Result<void> checkCorners() const;
  std::vector<Mesh4d> split(const std::vector<std::int64_t>& parts,
                            const std::map<std::int64_t, std::string>& names);

  Place file_;
  PlaceOf placeOf_;
  unsigned firstIndex_;
  std::vector<model::Point4> vertices_;
  std::vector<model::Cell> cells_;
  std::vector<std::int64_t> parts_;  // of each cell; empty while all are of part firstPart_
  std::int64_t firstPart_ = 0;
  std::vector<model::Attribute> attributes_;
  std::vector<std::uint64_t> droppedCells_;  // their numbers among all that were added
  std::uint32_t largestCorner_ = 0;
  Position positionOfLargest_ = 0;
};

}  // namespace t4d::formats
