#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "model/progress.h"
#include "model/slab_groups.h"
#include "t4d/slice.h"

namespace t4d::slice {
namespace {

/// A source that keeps the last slab, so that it is not read again. Not thread-safe.
class LastSlabKept : public model::Source, public model::GroupedSource {
 public:
  explicit LastSlabKept(const model::Source& source) : source_(source) {}

  std::size_t slabCount() const override { return source_.slabCount(); }
  model::TimeSpan timeSpan(std::size_t index) const override { return source_.timeSpan(index); }
  const std::vector<model::SlabGroup>& groups() const override {
    return model::slabGroupsOf(source_);
  }
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override {
    if (index_ != index) {
      index_ = index;
      last_ = nullptr;  // avoids two slabs in memory
      last_ = source_.slab(index);
    }
    return last_;
  }

 private:
  const model::Source& source_;
  mutable std::optional<std::size_t> index_;
  mutable Result<std::shared_ptr<const model::Slab>> last_;
};

}  // namespace

std::vector<Result<Slice>> sliceAtTimes(const model::Source& source, std::span<const double> times,
                                        const model::Progress& progress, WithMotion withMotion) {
  // They are taken in time order, so that times within one slab are consecutive.
  std::vector<std::size_t> order(times.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) {
    return std::isnan(times[i]) ? -std::numeric_limits<double>::infinity() : times[i];
  };
  std::ranges::stable_sort(order, {}, key);

  const LastSlabKept kept(source);
  const TimeSlicer slicer(kept, withMotion);
  std::vector<Result<Slice>> slices(times.size());
  for (std::size_t done = 0; done < order.size(); ++done) {
    slices[order[done]] = slicer.at(times[order[done]]);
    const auto on = model::report(progress, done + 1, order.size());
    if (on) continue;
    for (std::size_t left = done + 1; left < order.size(); ++left) slices[order[left]] = on.error();
    break;
  }
  return slices;
}

}  // namespace t4d::slice
