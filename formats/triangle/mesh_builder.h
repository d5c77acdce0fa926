#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/triangle/corner_rows.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Checks the points and polygons of a file and makes a triangle mesh of them.
class MeshBuilder {
 public:
  /// The position of a face or point in the file; `PlaceOf` turns it into the `where` of an error.
  using Position = std::uint64_t;
  using PlaceOf = std::function<Place(Position)>;

  /// `firstIndex` is how the format counts vertices, for messages: from 0 or from 1.
  MeshBuilder(std::string file, PlaceOf placeOf, unsigned firstIndex = 0)
      : file_(std::move(file)), placeOf_(std::move(placeOf)), firstIndex_(firstIndex) {}

  /// Reserves memory; the caller has checked the counts against the size of the file.
  void reserve(std::size_t points, std::size_t polygons);

  /// Coordinates that are not finite are an error.
  Result<void> addPoint(const model::Point3& point, Position position);

  /// `corners` are the numbers of points, from 0; fewer than three are an error. A polygon may come
  /// before its points.
  Result<void> addPolygon(std::span<const std::uint64_t> corners, Position position);

  /// Adds the triangles of a strip. The corners of every second one are reversed, so that all face
  /// the same side. Triangles that use a corner twice only join strips: they are dropped without a
  /// notice. Fewer than three corners make no triangle.
  Result<void> addStrip(std::span<const std::uint64_t> corners, Position position);

  /// Polygons belong to this part from now on; to part 0 at first.
  void setPart(std::uint32_t part) { part_ = part; }

  std::size_t pointCount() const { return points_.size(); }
  std::span<const model::Point3> points() const { return points_; }
  /// For each point, the number of the first one with the same coordinates.
  std::vector<std::uint32_t> firstEquals() const;

  /// For each triangle of the mesh that `finish` makes, the part of its polygon. Filled by
  /// `finish`.
  void keepPartsIn(std::vector<std::uint32_t>& parts) { partsOfTriangles_ = &parts; }

  /// Where the corners of the triangles come from. Filled by `finish`. A polygon that comes to one
  /// vertex twice has the first of the two corners there.
  void keepCornersIn(FileCorners& corners) { cornersOfTriangles_ = &corners; }

  /// Merges points with equal coordinates, splits polygons into triangles, drops triangles with
  /// equal corners and vertices without triangles. Fails on an index out of range, and when no
  /// triangle is left.
  Result<LoadedMesh> finish() &&;

 private:
  struct Polygon {
    std::size_t end;  // in corners_
    Position position;
    std::uint32_t part;
  };

  Result<std::uint32_t> cornerOf(std::uint64_t index, Position position) const;
  Result<void> checkCorner(std::uint32_t corner, Position position) const;
  Result<void> checkCorners() const;
  /// Adds the corners of triangles that were made of a polygon, which has the corners from `begin`
  /// to `end` of all.
  void keepCorners(std::span<const model::Triangle> triangles, std::size_t begin, std::size_t end,
                   const std::vector<std::uint32_t>& first);

  std::string file_;
  PlaceOf placeOf_;
  unsigned firstIndex_;
  std::vector<model::Point3> points_;
  std::vector<std::uint32_t> corners_;
  std::vector<Polygon> polygons_;
  std::uint32_t part_ = 0;
  /// The largest corner of any strip, which need not be in a triangle.
  std::uint32_t largestOfStrips_ = 0;
  std::optional<Position> positionOfLargest_;
  std::vector<std::uint32_t>* partsOfTriangles_ = nullptr;
  FileCorners* cornersOfTriangles_ = nullptr;
  /// The corners of a polygon: the vertex and the number of each, in order.
  std::vector<std::pair<std::uint32_t, std::uint64_t>> numbered_;
};

}  // namespace t4d::formats
