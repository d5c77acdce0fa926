#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::voxel4d {

/// Finds which of many boxes overlap another one. A binary tree of bounds, whose boxes are split at
/// the median of their centres along the longest axis.
class BoxTree {
 public:
  explicit BoxTree(std::vector<model::Bounds3> boxes);

  /// Calls visit(index) for each box that has a point in common with `box`.
  template <class Visit>
  void visitOverlapping(const model::Bounds3& box, const Visit& visit) const {
    if (nodes_.empty()) return;
    // Halving keeps the depth below 33, and each level leaves at most one node.
    std::array<std::uint32_t, 40> waiting;
    std::size_t count = 0;
    waiting[count++] = 0;
    while (count > 0) {
      const std::uint32_t index = waiting[--count];
      const Node& node = nodes_[index];
      if (!overlap(node.bounds, box)) continue;
      if (node.count == 0) {
        waiting[count++] = node.first;
        waiting[count++] = index + 1;
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        if (overlap(boxes_[i], box)) visit(order_[i]);
      }
    }
  }

 private:
  struct Node {
    model::Bounds3 bounds;
    std::uint32_t first = 0;  // of its boxes in order_; for an inner node, the second child
    std::uint32_t count = 0;  // 0 for an inner node, whose first child is the next node
  };

  static bool overlap(const model::Bounds3& a, const model::Bounds3& b) {
    return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
  }
  void build(std::uint32_t begin, std::uint32_t end);

  std::vector<model::Bounds3> boxes_;  // in the order of the tree
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace t4d::voxel4d
