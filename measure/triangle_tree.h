#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "model/unit_scale.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// A bounding box tree over the triangles of a mesh that finds the triangle nearest to a point,
/// whatever their size.
/// Each node's triangles are split at the median along the longest axis of their centres.
class TriangleTree {
 public:
  /// `mesh` must have at least one triangle. The tree copies the corners.
  explicit TriangleTree(const model::TriangleMesh& mesh);

  struct Nearest {
    std::uint32_t triangle = 0;  ///< its index in the mesh
    double distance = 0;         ///< exact up to rounding
  };

  /// The triangle nearest to a point; any of them if several are equally near. Without one nearer
  /// than `most`, the distance is `most`: that is found out sooner.
  Nearest nearest(const model::Point3& point,
                  double most = std::numeric_limits<double>::infinity()) const;

  /// The distance of the triangle nearest to another one, or less by rounding; `most` without one
  /// nearer than that.
  double distanceFrom(const std::array<model::Point3, 3>& triangle, double most) const;

  /// Calls visit(triangle) for all triangles whose boxes meet a box.
  template <class Visit>
  void forEachReaching(const model::Bounds3& box, const Visit& visit) const;

  /// Distance from a point to one triangle.
  double distanceTo(std::uint32_t triangle, const model::Point3& point) const;

 private:
  struct Node {
    model::Bounds3 bounds;
    std::uint32_t first = 0;  // of its triangles in order_; for an inner node, the second child
    std::uint32_t count = 0;  // 0 for an inner node, whose first child is the next node
  };

  void build(std::uint32_t begin, std::uint32_t end, const std::vector<model::Point3>& centres);

  /// Calls visit(triangle), which returns the square of the best distance so far, for the triangles
  /// in boxes that are nearer than that, near ones first.
  template <class SquaredDistance, class Visit>
  void visitNear(const SquaredDistance& toBox, double best, const Visit& visit) const;

  Nearest nearestInUnit(const model::Point3& point, double most) const;

  model::UnitScale scale_;
  std::vector<std::array<model::Point3, 3>>
      corners_;  // in the unit of the scale, as all that follows
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

template <class Visit>
void TriangleTree::forEachReaching(const model::Bounds3& box, const Visit& visit) const {
  const model::Bounds3 inUnit{scale_.toUnit(box.min), scale_.toUnit(box.max)};
  const auto reaches = [&](const model::Bounds3& other) {
    return (other.min.array() <= inUnit.max.array()).all() &&
           (other.max.array() >= inUnit.min.array()).all();
  };
  std::vector<std::uint32_t> waiting = {0};
  while (!waiting.empty()) {
    const std::uint32_t index = waiting.back();
    waiting.pop_back();
    const Node& node = nodes_[index];
    if (!reaches(node.bounds)) continue;
    if (node.count == 0) {
      waiting.push_back(node.first);
      waiting.push_back(index + 1);
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      model::Bounds3 own;
      for (const model::Point3& corner : corners_[order_[i]]) own.add(corner);
      if (reaches(own)) visit(order_[i]);
    }
  }
}

}  // namespace t4d::measure
