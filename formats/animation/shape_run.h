#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/animation/key_divider.h"
#include "t4d/motion.h"

namespace t4d::formats {

/// A body of an animation at its keys, from one jump to the next. The last key is the end of what
/// is before it.
class ShapeRun : public model::VertexKeys {
 public:
  /// `vertices` are those of the body's mesh, which is the mirror image of the shape in x = 0 if it
  /// is `mirrored`, unless the shape deforms.
  ShapeRun(std::shared_ptr<const MovingShape> shape,
           std::shared_ptr<const std::vector<model::Point3>> vertices, std::vector<double> times,
           bool mirrored)
      : shape_(std::move(shape)),
        vertices_(std::move(vertices)),
        times_(std::move(times)),
        mirrored_(mirrored) {}

  std::uint64_t count() const override { return times_.size(); }
  double time(std::uint64_t key) const override { return times_[key]; }

  std::optional<model::Affine3x4> pose(std::uint64_t key) const override {
    auto world = shape_->pose(times_[key], isEnd(key));
    if (!world) return std::nullopt;
    if (mirrored_) *world = *world * Eigen::Scaling(-1.0, 1.0, 1.0);
    return world->matrix().topRows<3>();
  }

  Result<void> positions(std::uint64_t key, std::span<model::Point3> into) const override {
    const auto matrix = pose(key);
    if (!matrix) {
      shape_->place(times_[key], isEnd(key), into);
      return {};
    }
    for (std::size_t i = 0; i < into.size(); ++i) into[i] = model::posed(*matrix, (*vertices_)[i]);
    return {};
  }

 private:
  bool isEnd(std::uint64_t key) const { return key + 1 == times_.size(); }

  std::shared_ptr<const MovingShape> shape_;
  std::shared_ptr<const std::vector<model::Point3>> vertices_;
  std::vector<double> times_;
  bool mirrored_;
};

}  // namespace t4d::formats
