#include "formats/t4d/grouped_body.h"

#include <algorithm>

namespace t4d::formats {

GroupedBody::Place GroupedBody::placeOf(std::size_t index) const {
  const auto group = std::ranges::upper_bound(groups_, index, {}, &model::SlabGroup::end);
  return {static_cast<std::size_t>(group - groups_.begin()), index - group->first};
}

model::TimeSpan GroupedBody::timeSpan(std::size_t index) const {
  const Place at = placeOf(index);
  const auto slabs = open_(at.group);
  return slabs ? (*slabs)->timeSpan(at.slab) : groups_[at.group].time;
}

std::optional<model::Bounds3> GroupedBody::bounds(std::size_t index) const {
  const Place at = placeOf(index);
  const auto slabs = open_(at.group);
  return slabs ? (*slabs)->bounds(at.slab) : groups_[at.group].bounds;
}

std::optional<std::uint64_t> GroupedBody::cellCount(std::size_t index) const {
  const Place at = placeOf(index);
  const auto slabs = open_(at.group);
  return slabs ? (*slabs)->cellCount(at.slab) : std::nullopt;
}

Result<std::shared_ptr<const model::Slab>> GroupedBody::slab(std::size_t index) const {
  const Place at = placeOf(index);
  const auto slabs = open_(at.group);
  if (!slabs) return slabs.error();
  return (*slabs)->slab(at.slab);
}

Result<std::shared_ptr<const model::SlabBlocks>> GroupedBody::blocks(std::size_t index) const {
  const Place at = placeOf(index);
  const auto slabs = open_(at.group);
  if (!slabs) return slabs.error();
  auto blocks = (*slabs)->blocks(at.slab);
  if (!blocks || !*blocks) return blocks;
  // They are read later, so the group stays open.
  const model::SlabBlocks* pointer = blocks->get();
  return std::shared_ptr<const model::SlabBlocks>(
      pointer, [slabs = *slabs, blocks = std::move(*blocks)](const model::SlabBlocks*) {});
}

Result<std::shared_ptr<const model::LayeredSlab>> GroupedBody::layered(std::size_t index) const {
  const Place at = placeOf(index);
  const auto slabs = open_(at.group);
  if (!slabs) return std::shared_ptr<const model::LayeredSlab>();  // `slab` says why
  return (*slabs)->layered(at.slab);
}

}  // namespace t4d::formats
