#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "model/shared_parts.h"
#include "model/slab_groups.h"

namespace t4d::formats {

/// Things that are opened when they are needed first, of which a few stay open: parts of a file, or
/// pages of its index. Safe from several threads at once.
template <class Thing>
class OpenThings {
 public:
  using Pointer = std::shared_ptr<const Thing>;
  using Open = std::function<Result<Pointer>(std::size_t number)>;

  explicit OpenThings(Open open) : open_(std::move(open)) {}

  Result<Pointer> get(std::size_t number) const {
    const auto made = known_.get(number, [&] { return open_(number); });
    if (!made) return made.error();
    const Pointer thing(*made, (*made)->get());
    const std::scoped_lock lock(mutex_);
    std::erase_if(recent_, [&](const Pointer& each) { return each.get() == thing.get(); });
    recent_.push_back(thing);
    if (recent_.size() > kMostOpen) recent_.pop_front();
    return thing;
  }

  /// Calls `use` with each that is open.
  template <class Use>
  void each(Use use) const {
    const std::scoped_lock lock(mutex_);
    for (const Pointer& thing : recent_) use(*thing);
  }

 private:
  /// The most that are open, except for those of which somebody has blocks.
  static constexpr std::size_t kMostOpen = 8;

  Open open_;
  mutable model::SharedParts<std::size_t, Pointer> known_;
  mutable std::mutex mutex_;
  mutable std::deque<Pointer> recent_;
};

/// The slabs of a body in groups, each of which is opened when it is needed.
class GroupedBody : public model::Source, public model::GroupedSource {
 public:
  /// A group's slabs; it stays open while somebody has them.
  using Open = std::function<Result<std::shared_ptr<const model::Source>>(std::size_t group)>;

  GroupedBody(std::vector<model::SlabGroup> groups, Open open)
      : groups_(std::move(groups)), open_(std::move(open)) {}

  /// A group, and the number of a slab in it.
  struct Place {
    std::size_t group = 0;
    std::size_t slab = 0;
  };
  Place placeOf(std::size_t index) const;

  const std::vector<model::SlabGroup>& groups() const override { return groups_; }
  std::size_t slabCount() const override { return groups_.back().end; }
  model::TimeSpan timeSpan(std::size_t index) const override;
  std::optional<model::Bounds3> bounds(std::size_t index) const override;
  std::optional<std::uint64_t> cellCount(std::size_t index) const override;
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override;
  Result<std::shared_ptr<const model::SlabBlocks>> blocks(std::size_t index) const override;
  Result<std::shared_ptr<const model::LayeredSlab>> layered(std::size_t index) const override;

 private:
  std::vector<model::SlabGroup> groups_;
  Open open_;
};

}  // namespace t4d::formats
