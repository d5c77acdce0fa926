#include "model/converted_source.h"

namespace t4d::model {

TimeSpan ConvertedSource::timeSpan(std::size_t index) const {
  const TimeSpan span = source_->timeSpan(index);
  return {time_(span.begin), time_(span.end)};
}

Result<std::shared_ptr<const Slab>> ConvertedSource::slab(std::size_t index) const {
  const auto read = source_->slab(index);
  if (!read) return read.error();
  auto slab = std::make_shared<Slab>(**read);
  slab->timeBegin = time_(slab->timeBegin);
  slab->timeEnd = time_(slab->timeEnd);
  for (Point4& vertex : slab->vertices) {
    for (int axis = 0; axis < 3; ++axis) vertex[axis] = length_(vertex[axis]);
    vertex[3] = time_(vertex[3]);
  }
  // Rounding makes the mean of converted points differ from the converted mean.
  setMeans(*slab->connectivity, slab->vertices);
  return slab;
}

}  // namespace t4d::model
