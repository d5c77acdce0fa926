#include "t4d/slice.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <unordered_map>

#include <fmt/format.h>

#include "model/parallel.h"
#include "model/progress.h"
#include "model/slab_groups.h"
#include "slice/slab_at_time.h"
#include "slice/slab_cutter.h"

namespace t4d::slice {
namespace {

using model::Attribute;
using model::Domain;
using model::Point4;
using model::Slab;
using model::Triangle;

}  // namespace

class Slicer::Impl {
 public:
  Impl(const Hyperplane& hyperplane, OnHyperplane rule, std::shared_ptr<CutMemory> memory,
       WithMotion withMotion = WithMotion::No)
      : cutter(hyperplane, rule, std::move(memory), withMotion) {
    if (withMotion == WithMotion::Yes) slice_.motion.emplace();
  }

  const SlabCutter cutter;

  /// Takes slabs in the order of time.
  void add(CutSlab made) {
    const model::VertexCounts& counts = made.counts;
    const Cut& cut = *made.cut;
    ++slice_.slabsRead;
    slice_.blocksRead += made.blocksRead;
    if (counts.lowerCount != lastUpperCount_) seam_.clear();

    std::vector<std::uint32_t> number(cut.points.size());  // in the slice
    std::vector<std::uint32_t> added;                      // points
    std::vector<model::Point3>& vertices = slice_.mesh.vertices;
    const auto first = static_cast<std::uint32_t>(vertices.size());
    if (seam_.empty()) {
      // All points are new.
      std::iota(number.begin(), number.end(), first);
      added.resize(cut.points.size());
      std::iota(added.begin(), added.end(), 0U);
      if (first == 0) {
        vertices = std::move(made.positions);
      } else {
        vertices.insert(vertices.end(), made.positions.begin(), made.positions.end());
      }
    } else {
      for (std::uint32_t i = 0; i < cut.points.size(); ++i) {
        const auto [below, above] = cut.points[i];
        const bool onSeam = std::max(below, above) < counts.lowerCount;
        const auto found = onSeam ? seam_.find(keyOf(below, above)) : seam_.end();
        if (found != seam_.end()) {
          number[i] = found->second;
          continue;
        }
        number[i] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(made.positions[i]);
        added.push_back(i);
      }
    }
    seam_.clear();
    lastUpperCount_ = counts.upperCount;
    const std::uint32_t firstUpper = counts.firstUpper();
    for (std::uint32_t i = 0; i < cut.points.size(); ++i) {
      const auto [below, above] = cut.points[i];
      if (std::min(below, above) < firstUpper) continue;
      seam_.emplace(keyOf(below - firstUpper, above - firstUpper), number[i]);
    }
    std::vector<Triangle>& triangles = slice_.mesh.triangles;
    const std::size_t before = triangles.size();
    triangles.insert(triangles.end(), cut.triangles.begin(), cut.triangles.end());
    const bool rightHanded = cutter.basis().rightHanded;
    for (std::size_t i = before; i < triangles.size() && !(first == 0 && rightHanded); ++i) {
      for (std::uint32_t& corner : triangles[i]) corner = number[corner];
      if (!rightHanded) std::swap(triangles[i][1], triangles[i][2]);
    }
    if (!cut.triangles.empty()) carryAttributes(made, added);
    // A slice at a time has the motion of the one slab that gives it.
    if (slice_.motion) slice_.motion = std::move(made.motion);
  }

  /// Called instead of adding the next slab, which the hyperplane misses.
  void skip() {
    seam_.clear();
    lastUpperCount_ = 0;
  }

  Slice finish() { return std::move(slice_); }
  Slice finish(const model::Source& source) {
    slice_.slabsSkipped = source.slabCount() - slice_.slabsRead;
    return finish();
  }

 private:
  static std::uint64_t keyOf(std::uint32_t below, std::uint32_t above) {
    return std::uint64_t{below} << 32U | above;
  }
  void carryAttributes(const CutSlab& made, const std::vector<std::uint32_t>& added);

  Slice slice_;
  /// Points on the upper layer of the last slab, by their vertices in the layer.
  std::unordered_map<std::uint64_t, std::uint32_t> seam_;
  std::uint32_t lastUpperCount_ = 0;
  bool hasAttributes_ = false;
};

/// Appends the rows of the new triangles and vertices to the slice's attributes. The first slab
/// that is cut defines them; an attribute that a later slab lacks is lost.
void Slicer::Impl::carryAttributes(const CutSlab& made, const std::vector<std::uint32_t>& added) {
  const std::vector<const Attribute*>& given = made.attributes;
  std::vector<Attribute>& carried = slice_.mesh.attributes;
  if (!hasAttributes_) {
    hasAttributes_ = true;
    for (const Attribute* attribute : given) {
      carried.push_back(
          {attribute->name, attribute->domain, attribute->type, attribute->components, {}});
    }
  }
  const auto match = [&](const Attribute& wanted) -> const Attribute* {
    const auto at = std::find_if(given.begin(), given.end(), [&](const Attribute* attribute) {
      return attribute->name == wanted.name && attribute->domain == wanted.domain &&
             attribute->type == wanted.type && attribute->components == wanted.components;
    });
    return at == given.end() ? nullptr : *at;
  };
  std::erase_if(carried, [&](const Attribute& attribute) {
    if (match(attribute) != nullptr) return false;
    slice_.losses.push_back(
        fmt::format("attribute '{}': not every slab that was cut has it", attribute.name));
    return true;
  });
  for (Attribute& attribute : carried) {
    const Attribute& from = *match(attribute);
    const std::size_t bytes = from.rowBytes();
    const std::size_t before = attribute.values.size();
    if (attribute.domain == Domain::Cell) {
      attribute.values.resize(before + made.cut->cells.size() * bytes);
      std::byte* into = attribute.values.data() + before;
      for (const std::uint32_t cell : made.cut->cells) {
        std::memcpy(into, from.row(cell), bytes);
        into += bytes;
      }
      continue;
    }
    attribute.values.resize(before + added.size() * bytes);
    std::byte* row = attribute.values.data() + before;
    for (const std::uint32_t i : added) {
      const Cut::Point& point = made.cut->points[i];
      interpolateRow(from, point.below, point.above, made.fractions[i], row);
      row += bytes;
    }
  }
}

Slicer::Slicer(const Hyperplane& hyperplane, OnHyperplane rule)
    : impl_(std::make_unique<Impl>(hyperplane, rule, std::make_shared<CutMemory>())) {}

Slicer::~Slicer() = default;

Result<void> Slicer::put(const Slab& slab) {
  auto cut = impl_->cutter.cut(slab);
  if (!cut) return cut.error();
  impl_->add(std::move(*cut));
  return {};
}

Slice Slicer::finish() { return impl_->finish(); }

class TimeSlicer::Impl {
 public:
  Impl(const model::Source& source, WithMotion withMotion)
      : source_(source), withMotion_(withMotion) {}
  Result<Slice> at(double given) const;

 private:
  const model::Source& source_;
  WithMotion withMotion_;
  std::shared_ptr<CutMemory> memory_ = std::make_shared<CutMemory>();
};

TimeSlicer::TimeSlicer(const model::Source& source, WithMotion withMotion)
    : impl_(std::make_unique<Impl>(source, withMotion)) {}

TimeSlicer::~TimeSlicer() = default;

Result<Slice> TimeSlicer::at(double time) const { return impl_->at(time); }

Result<Slice> TimeSlicer::Impl::at(double given) const {
  const auto at = slabAtTime(source_, given);
  if (!at) return at.error();
  Slicer::Impl slicer(Hyperplane::atTime(at->time),
                      at->atEnd ? OnHyperplane::Above : OnHyperplane::Below, memory_, withMotion_);
  if (at->slab) {
    const auto open = openSlab(source_, *at->slab);
    if (!open) return open.error();
    auto cut = slicer.cutter.cut(*open);
    if (!cut) return cut.error();
    slicer.add(std::move(*cut));
  }
  return slicer.finish(source_);
}

Result<Slice> sliceAtTime(const model::Source& source, double time) {
  return TimeSlicer(source).at(time);
}

Result<Slice> slice(const model::Source& source, const Hyperplane& hyperplane,
                    const model::Progress& progress) {
  if (auto checked = checkHyperplane(hyperplane); !checked) return checked.error();
  const Eigen::Vector4d& n = hyperplane.normal;
  if (n.head<3>().isZero(0)) return sliceAtTime(source, hyperplane.offset / n[3]);
  Slicer::Impl slicer(hyperplane, OnHyperplane::Below, std::make_shared<CutMemory>());
  const std::size_t count = source.slabCount();
  struct Item {
    Result<OpenSlab> open = OpenSlab();  // neither, for a slab that the hyperplane misses
    Result<CutSlab> cut;
    bool missed() const { return open && open->none(); }
  };
  using ItemPointer = std::shared_ptr<Item>;
  // One after another, so that parts that slabs share are read once.
  const auto isMissed = [&](const model::Bounds3& bounds, const model::TimeSpan& time) {
    model::Bounds4 all;
    all.min << bounds.min, time.begin;
    all.max << bounds.max, time.end;
    return slicer.cutter.misses(all);
  };
  auto group = model::slabGroupsOf(source).begin();
  const auto groupIsMissed = [&, end = model::slabGroupsOf(source).end()](std::size_t index) {
    while (group != end && index >= group->end) ++group;
    return group != end && isMissed(group->bounds, group->time);
  };
  const auto read = [&](std::size_t index) {
    auto item = std::make_shared<Item>();
    if (groupIsMissed(index)) return item;
    if (const auto bounds = source.bounds(index)) {
      if (isMissed(*bounds, source.timeSpan(index))) return item;
    }
    item->open = openPartly(source, index);
    return item;
  };
  const auto cut = [&](ItemPointer item) {
    if (item->open && !item->missed()) item->cut = slicer.cutter.cut(*item->open);
    return item;
  };
  std::optional<Error> error;  // the first one
  std::size_t done = 0;
  const auto take = [&](const ItemPointer& item) {
    if (!item->open) {
      error = item->open.error();
    } else if (item->missed()) {
      slicer.skip();
    } else if (!item->cut) {
      error = item->cut.error();
    } else {
      slicer.add(std::move(*item->cut));
    }
    if (const auto on = model::report(progress, ++done, count); !on && !error) error = on.error();
    return !error;
  };
  model::inOrder<ItemPointer, ItemPointer>(count, model::threadCount(), read, cut, take);
  if (error) return *error;
  return slicer.finish(source);
}

}  // namespace t4d::slice
