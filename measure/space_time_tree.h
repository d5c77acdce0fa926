#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// A tree over boxes in space-time that finds those near to another box. Each node is split at the
/// median of the longest axis of the middles of its boxes.
class SpaceTimeTree {
 public:
  /// Empty boxes are never found.
  explicit SpaceTimeTree(std::vector<model::Bounds4> boxes);

  /// Whether is(number) holds for any box of isNear; asks in no order that means anything, and no
  /// further than the first.
  template <class Is>
  bool anyNear(const model::Bounds4& box, double distance, Is is) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (!meets(node.box, box, distance)) {
        i = node.next;
        continue;
      }
      ++i;
      for (std::uint32_t k = node.begin; k < node.end; ++k) {
        if (isNear(order_[k], box, distance) && is(order_[k])) return true;
      }
    }
    return false;
  }

  /// Whether a box has a time in common with another and, along each axis of space, is no farther
  /// from it than `distance`.
  bool isNear(std::uint32_t number, const model::Bounds4& box, double distance) const {
    return meets(boxes_[number], box, distance);
  }

 private:
  struct Node {
    model::Bounds4 box;
    std::uint32_t begin = 0;  // of the boxes of a leaf, in order_; none for an inner node
    std::uint32_t end = 0;
    std::size_t next = 0;  // the node after it and all below it
  };

  static bool meets(const model::Bounds4& a, const model::Bounds4& b, double distance) {
    const model::Point4 reach(distance, distance, distance, 0);
    return ((a.min - reach).array() <= b.max.array()).all() &&
           ((a.max + reach).array() >= b.min.array()).all();
  }
  void build(std::uint32_t begin, std::uint32_t end);

  std::vector<model::Bounds4> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace t4d::measure
