#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/triangle_mesh_reader.h"
#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::formats {

/// Makes the triangle mesh of the points and polygons that a reader finds, and judges them.
class MeshBuilder {
 public:
  /// Where something stands in the file; `PlaceText` makes the `where` of an error from it.
  using Place = std::uint64_t;
  using PlaceText = std::function<std::string(Place)>;

  /// `firstIndex` is how the format counts vertices, for messages: from 0 or from 1.
  MeshBuilder(std::string file, PlaceText placeText, unsigned firstIndex = 0)
      : file_(std::move(file)), placeText_(std::move(placeText)), firstIndex_(firstIndex) {}

  /// Room for as many; the caller has checked the counts against the size of the file.
  void reserve(std::size_t points, std::size_t polygons);

  /// Coordinates that are not finite are an error.
  Result<void> addPoint(const model::Point3& point, Place place);

  /// `corners` are the numbers of points, from 0; fewer than three are an error. A polygon may
  /// stand before its points.
  Result<void> addPolygon(std::span<const std::uint64_t> corners, Place place);

  /// Adds the triangles of a strip, the second, fourth, ... turned over, so that all of them face
  /// to the side of the first. Triangles that name a corner twice are what strips are joined by:
  /// they are left out without a notice. Fewer than three corners make no triangle.
  Result<void> addStrip(std::span<const std::uint64_t> corners, Place place);

  std::size_t pointCount() const { return points_.size(); }

  /// Merges points with equal coordinates, splits polygons into triangles, drops triangles with
  /// equal corners and vertices without triangles. Fails on an index out of range, and when no
  /// triangle is left.
  Result<LoadedMesh> finish() &&;

 private:
  struct Polygon {
    std::size_t end;  // in corners_
    Place place;
  };

  Result<std::uint32_t> cornerOf(std::uint64_t index, Place place) const;
  Result<void> checkCorner(std::uint32_t corner, Place place) const;
  Result<void> checkCorners() const;
  /// The number of the first point with the same coordinates, for each point.
  std::vector<std::uint32_t> firstEquals() const;

  std::string file_;
  PlaceText placeText_;
  unsigned firstIndex_;
  std::vector<model::Point3> points_;
  std::vector<std::uint32_t> corners_;
  std::vector<Polygon> polygons_;
  /// The largest corner of any strip: it may stand in none of the strip's triangles.
  std::uint32_t largestOfStrips_ = 0;
  std::optional<Place> placeOfLargest_;
};

}  // namespace t4d::formats
