#include "measure/space_time_tree.h"

#include <algorithm>

namespace t4d::measure {

using model::Bounds4;
using model::Point4;

SpaceTimeTree::SpaceTimeTree(std::vector<Bounds4> boxes) : boxes_(std::move(boxes)) {
  for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
    if (!boxes_[i].empty()) order_.push_back(i);
  }
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
}

void SpaceTimeTree::build(std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t kLeafBoxes = 4;
  Bounds4 all;
  Bounds4 middles;
  const auto middle = [&](std::uint32_t box) {
    return Point4((boxes_[box].min + boxes_[box].max) / 2);
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

}  // namespace t4d::measure
