#include "formats/triangle/mesh_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include <fmt/format.h>

#include "formats/triangle/polygon_triangulation.h"

namespace t4d::formats {
namespace {

using model::Point3;

constexpr std::uint32_t kNone = FilePoints::kUnused;

/// The hash of what has `hash` so far, and `next` behind it: the finaliser of splitmix64, which
/// scatters neighbouring numbers.
std::uint64_t hashWith(std::uint64_t hash, std::uint64_t next) {
  hash += next + 0x9e3779b97f4a7c15;
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111eb;
  return hash ^ (hash >> 31);
}

std::uint64_t hashOf(const Point3& point) {
  std::uint64_t hash = 0;
  for (int i = 0; i < 3; ++i) hash = hashWith(hash, std::bit_cast<std::uint64_t>(point[i]));
  return hash;
}

/// Removes corners that equal the one before.
void dropRepeats(std::vector<std::uint32_t>& corners) {
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
}

template <class Index>
bool hasEqualCorners(const std::array<Index, 3>& triangle) {
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

std::string droppedNotice(std::size_t count, const char* one, const char* many, const char* why) {
  return fmt::format("dropped {} {} {}", count, count == 1 ? one : many, why);
}

/// Keeps the vertices that triangles use, in their order; returns how many went. Replaces the first
/// equal point of each point by its vertex.
std::size_t dropUnused(std::vector<Point3>& points, std::vector<model::Triangle>& triangles,
                       std::vector<std::uint32_t>& firstEqual) {
  std::vector<std::uint32_t> newNumber(points.size(), kNone);
  for (const auto& triangle : triangles) {
    for (const std::uint32_t corner : triangle) newNumber[corner] = 0;
  }
  std::uint32_t kept = 0;
  std::size_t dropped = 0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (newNumber[i] == kNone) {
      dropped += firstEqual[i] == i;
      continue;
    }
    newNumber[i] = kept;
    points[kept++] = points[i];
  }
  points.resize(kept);
  for (auto& triangle : triangles) {
    for (std::uint32_t& corner : triangle) corner = newNumber[corner];
  }
  for (std::uint32_t& point : firstEqual) point = newNumber[point];
  return dropped;
}

}  // namespace

void MeshBuilder::reserve(std::size_t points, std::size_t polygons) {
  points_.reserve(points);
  corners_.reserve(3 * polygons);
  polygons_.reserve(polygons);
}

Result<void> MeshBuilder::addPoint(const Point3& point, Position position) {
  if (!point.allFinite()) {
    return invalid(fmt::format("vertex {} is ({}, {}, {}), expected finite coordinates",
                               points_.size() + firstIndex_, point.x(), point.y(), point.z()),
                   placeOf_(position));
  }
  if (points_.size() == kNone) {
    return fail(ErrorCode::Unsupported, "holds more vertices than 32-bit indices can count",
                placeOf_(position));
  }
  // Adding zero turns -0 into +0, so that equal coordinates have equal bits.
  points_.push_back(point + Point3::Zero());
  return {};
}

Result<void> MeshBuilder::addPolygon(std::span<const std::uint64_t> corners, Position position) {
  if (corners.size() < 3) {
    return invalid(fmt::format("a face of {} corners, expected at least 3", corners.size()),
                   placeOf_(position));
  }
  for (const std::uint64_t index : corners) {
    const auto corner = cornerOf(index, position);
    if (!corner) return corner.error();
    corners_.push_back(*corner);
  }
  polygons_.push_back({corners_.size(), position, part_});
  return {};
}

Result<void> MeshBuilder::addStrip(std::span<const std::uint64_t> corners, Position position) {
  for (const std::uint64_t index : corners) {
    const auto corner = cornerOf(index, position);
    if (!corner) return corner.error();
    if (positionOfLargest_ && *corner <= largestOfStrips_) continue;
    largestOfStrips_ = *corner;
    positionOfLargest_ = position;
  }
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    const std::array<std::uint64_t, 3> triangle{corners[i], corners[i + 1 + i % 2],
                                                corners[i + 2 - i % 2]};
    if (hasEqualCorners(triangle)) continue;
    if (auto added = addPolygon(triangle, position); !added) return added;
  }
  return {};
}

Result<std::uint32_t> MeshBuilder::cornerOf(std::uint64_t index, Position position) const {
  if (index >= kNone) {
    return invalid(
        fmt::format("a face refers to vertex {}, beyond any that can exist", index + firstIndex_),
        placeOf_(position));
  }
  return static_cast<std::uint32_t>(index);
}

Result<void> MeshBuilder::checkCorner(std::uint32_t corner, Position position) const {
  if (corner < points_.size()) return {};
  return invalid(fmt::format("a face refers to vertex {}, but there are {} (counted from {})",
                             std::uint64_t{corner} + firstIndex_, points_.size(), firstIndex_),
                 placeOf_(position));
}

Result<void> MeshBuilder::checkCorners() const {
  std::size_t i = 0;
  for (const Polygon& polygon : polygons_) {
    for (; i < polygon.end; ++i) {
      if (auto checked = checkCorner(corners_[i], polygon.position); !checked) return checked;
    }
  }
  if (!positionOfLargest_) return {};
  return checkCorner(largestOfStrips_, *positionOfLargest_);
}

std::vector<std::uint32_t> MeshBuilder::firstEquals() const {
  // An open hash table of point numbers, at most half full.
  const std::size_t mask = std::bit_ceil(2 * points_.size() + 1) - 1;
  std::vector<std::uint32_t> table(mask + 1, kNone);
  std::vector<std::uint32_t> first(points_.size());
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    std::size_t slot = hashOf(points_[i]) & mask;
    while (table[slot] != kNone && points_[table[slot]] != points_[i]) slot = (slot + 1) & mask;
    if (table[slot] == kNone) table[slot] = i;
    first[i] = table[slot];
  }
  return first;
}

void MeshBuilder::keepCorners(std::span<const model::Triangle> triangles, std::size_t begin,
                              std::size_t end, const std::vector<std::uint32_t>& first) {
  numbered_.clear();
  for (std::size_t i = begin; i < end; ++i) numbered_.emplace_back(first[corners_[i]], i);
  std::ranges::sort(numbered_);
  for (const model::Triangle& triangle : triangles) {
    auto& made = cornersOfTriangles_->ofTriangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::pair<std::uint32_t, std::uint64_t> least{triangle[k], 0};
      made[k] = std::ranges::lower_bound(numbered_, least)->second;
    }
  }
}

Result<LoadedMesh> MeshBuilder::finish() && {
  if (auto checked = checkCorners(); !checked) return checked.error();

  auto first = firstEquals();
  LoadedMesh loaded;
  auto& triangles = loaded.mesh.triangles;
  triangles.reserve(corners_.size() - 2 * polygons_.size());
  PolygonTriangulator triangulator;
  std::vector<std::uint32_t> corners;
  std::size_t degenerate = 0;
  std::ptrdiff_t whole = 0;  // of the triangles
  std::size_t begin = 0;
  std::uint64_t hash = 0;
  for (const auto& [end, position, part] : polygons_) {
    const std::size_t firstCorner = begin;
    corners.clear();
    hash = hashWith(hash, end);
    for (; begin < end; ++begin) {
      hash = hashWith(hash, corners_[begin]);
      corners.push_back(first[corners_[begin]]);
    }
    dropRepeats(corners);
    if (corners.size() < 3) {
      ++degenerate;
    } else if (!triangulator.add(points_, corners, triangles)) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("a concave face of {} corners takes too long to split into "
                              "triangles; triangulate it first",
                              corners.size()),
                  placeOf_(position));
    }
    const auto added = std::ranges::remove_if(triangles.begin() + whole, triangles.end(),
                                              hasEqualCorners<std::uint32_t>);
    degenerate += added.size();
    triangles.erase(added.begin(), added.end());
    if (cornersOfTriangles_ != nullptr) {
      const auto made = static_cast<std::size_t>(whole);
      keepCorners(std::span(triangles).subspan(made), firstCorner, end, first);
    }
    whole = std::ssize(triangles);
    if (partsOfTriangles_ != nullptr) partsOfTriangles_->resize(triangles.size(), part);
  }
  if (degenerate > 0) {
    loaded.notices.push_back(
        droppedNotice(degenerate, "triangle", "triangles", "with two equal corners"));
  }
  if (triangles.empty()) return invalid("holds no triangles", file_);

  const std::size_t unused = dropUnused(points_, triangles, first);
  if (unused > 0) {
    loaded.notices.push_back(droppedNotice(unused, "vertex", "vertices", "that no triangle uses"));
  }
  if (cornersOfTriangles_ != nullptr) cornersOfTriangles_->points = std::move(corners_);
  loaded.mesh.vertices = std::move(points_);
  loaded.points = {std::move(first), polygons_.size(), hash};
  return loaded;
}

}  // namespace t4d::formats
