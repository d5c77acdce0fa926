#pragma once

#include "t4d/mesh.h"

namespace t4d::model {

/// Consecutive slabs of another source.
class SourcePart : public Source {
 public:
  /// The slabs from `begin` up to, not including, `end`. `whole` must outlive this view.
  SourcePart(const Source& whole, std::size_t begin, std::size_t end)
      : whole_(&whole), begin_(begin), count_(end - begin) {}

  std::size_t slabCount() const override { return count_; }
  TimeSpan timeSpan(std::size_t index) const override { return whole_->timeSpan(begin_ + index); }
  std::optional<Bounds3> bounds(std::size_t index) const override {
    return whole_->bounds(begin_ + index);
  }
  std::optional<std::uint64_t> cellCount(std::size_t index) const override {
    return whole_->cellCount(begin_ + index);
  }
  Result<std::shared_ptr<const Slab>> slab(std::size_t index) const override {
    return whole_->slab(begin_ + index);
  }
  Result<std::shared_ptr<const SlabBlocks>> blocks(std::size_t index) const override {
    return whole_->blocks(begin_ + index);
  }
  Result<std::shared_ptr<const LayeredSlab>> layered(std::size_t index) const override {
    return whole_->layered(begin_ + index);
  }

 private:
  const Source* whole_;
  std::size_t begin_;
  std::size_t count_;
};

}  // namespace t4d::model
