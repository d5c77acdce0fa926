#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::model {

/// Whether two boxes have a common point.
template <int Dimension>
bool overlap(const Bounds<Dimension>& a, const Bounds<Dimension>& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

/// The box of what is no farther than `distance` from a box along each axis of space, at its times.
inline Bounds4 widened(const Bounds4& box, double distance) {
  const Point4 by(distance, distance, distance, 0);
  return {box.min - by, box.max + by};
}

/// Finds which of many boxes overlap another one. A binary tree of bounds, whose boxes are split at
/// the median of their middles along the longest axis.
template <int Dimension>
class BoxTree {
 public:
  using Box = Bounds<Dimension>;

  /// Empty boxes are never found.
  explicit BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
      if (!boxes_[i].empty()) order_.push_back(i);
    }
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
  }

  const Box& operator[](std::uint32_t number) const { return boxes_[number]; }

  /// Whether is(number) holds for any box that overlaps this one; asks in no order that means
  /// anything, and no further than the first.
  template <class Is>
  bool anyOverlapping(const Box& box, Is is) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (!overlap(node.box, box)) {
        i = node.next;
        continue;
      }
      ++i;
      for (std::uint32_t k = node.begin; k < node.end; ++k) {
        if (overlap(boxes_[order_[k]], box) && is(order_[k])) return true;
      }
    }
    return false;
  }

  /// Calls visit(number) for each box that overlaps this one.
  template <class Visit>
  void visitOverlapping(const Box& box, Visit visit) const {
    anyOverlapping(box, [&](std::uint32_t number) {
      visit(number);
      return false;
    });
  }

 private:
  struct Node {
    Box box;
    std::uint32_t begin = 0;  // of the boxes of a leaf, in order_; none for an inner node
    std::uint32_t end = 0;
    std::size_t next = 0;  // the node after it and all below it
  };

  void build(std::uint32_t begin, std::uint32_t end) {
    constexpr std::uint32_t kLeafBoxes = 4;
    Box all;
    Box middles;  // twice as far out
    const auto middle = [&](std::uint32_t box) {
      return typename Box::Point(boxes_[box].min + boxes_[box].max);
    };
    for (std::uint32_t k = begin; k < end; ++k) {
      all.add(boxes_[order_[k]]);
      middles.add(middle(order_[k]));
    }
    const std::size_t node = nodes_.size();
    nodes_.push_back({all, begin, begin, 0});
    if (end - begin <= kLeafBoxes) {
      nodes_[node].end = end;
    } else {
      Eigen::Index axis = 0;
      (middles.max - middles.min).maxCoeff(&axis);
      const std::uint32_t half = begin + (end - begin) / 2;
      std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                       [&](std::uint32_t a, std::uint32_t b) {
                         const double at = middle(a)[axis];
                         const double other = middle(b)[axis];
                         return at != other ? at < other : a < b;
                       });
      build(begin, half);
      build(half, end);
    }
    nodes_[node].next = nodes_.size();
  }

  std::vector<Box> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace t4d::model
