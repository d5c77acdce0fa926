#include "voxel4d/box_tree.h"

#include <algorithm>
#include <numeric>

namespace t4d::voxel4d {

BoxTree::BoxTree(std::vector<model::Bounds3> boxes)
    : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (boxes_.empty()) return;
  build(0, static_cast<std::uint32_t>(order_.size()));
  std::vector<model::Bounds3> ordered;
  ordered.reserve(boxes_.size());
  for (const std::uint32_t i : order_) ordered.push_back(boxes_[i]);
  boxes_ = std::move(ordered);
}

void BoxTree::build(std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t kLeafBoxes = 4;
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  model::Bounds3 bounds;
  model::Bounds3 centres;
  for (std::uint32_t i = begin; i < end; ++i) {
    const model::Bounds3& box = boxes_[order_[i]];
    bounds.add(box);
    centres.add(model::Point3(box.min + box.max));
  }
  nodes_[self].bounds = bounds;
  if (end - begin <= kLeafBoxes) {
    nodes_[self].first = begin;
    nodes_[self].count = end - begin;
    return;
  }
  int axis = 0;
  (centres.max - centres.min).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto centre = [&](std::uint32_t i) { return boxes_[i].min[axis] + boxes_[i].max[axis]; };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return centre(a) != centre(b) ? centre(a) < centre(b) : a < b;
                   });
  build(begin, middle);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end);
}

}  // namespace t4d::voxel4d
