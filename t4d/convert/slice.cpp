#include "t4d/convert/slice.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <optional>
#include <unordered_map>

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>

#include "t4d/convert/cut.h"

namespace t4d::convert {
namespace {

using model::Attribute;
using model::Domain;
using model::Point4;
using model::ScalarType;
using model::Slab;
using model::Triangle;

template <class Scalar>
void interpolate(const std::byte* below, const std::byte* above, double fraction,
                 std::size_t components, std::byte* into) {
  for (std::size_t i = 0; i < components; ++i) {
    Scalar a;
    Scalar b;
    std::memcpy(&a, below + i * sizeof(Scalar), sizeof(Scalar));
    std::memcpy(&b, above + i * sizeof(Scalar), sizeof(Scalar));
    const auto value = static_cast<Scalar>(a + fraction * (static_cast<double>(b) - a));
    std::memcpy(into + i * sizeof(Scalar), &value, sizeof(Scalar));
  }
}

/// Cuts slabs and remembers what can be used again. Safe to use from several threads at once.
class Cutter {
 public:
  /// checkConnectivity, unless this connectivity was the last one that passed.
  Result<void> check(const std::shared_ptr<const model::Connectivity>& connectivity) {
    if (!connectivity) return {};  // refused by checkSlab
    {
      const std::scoped_lock lock(mutex_);
      if (connectivity == checked_) return {};
    }
    if (auto checked = checkConnectivity(*connectivity); !checked) return checked;
    const std::scoped_lock lock(mutex_);
    checked_ = connectivity;
    return {};
  }

  std::shared_ptr<const Cut> cut(const std::shared_ptr<const model::Connectivity>& connectivity,
                                 std::vector<std::uint8_t> sides) {
    {
      const std::scoped_lock lock(mutex_);
      if (connectivity == connectivity_ && sides == sides_) return last_;
    }
    auto made = std::make_shared<const Cut>(cutOf(connectivity->cells, sides));
    const std::scoped_lock lock(mutex_);
    connectivity_ = connectivity;
    sides_ = std::move(sides);
    last_ = made;
    return made;
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const model::Connectivity> checked_;
  std::shared_ptr<const model::Connectivity> connectivity_;
  std::vector<std::uint8_t> sides_;
  std::shared_ptr<const Cut> last_;
};

/// A slab, and what is cut of it.
struct CutSlab {
  const Slab* slab = nullptr;
  std::shared_ptr<const Cut> cut;
  std::vector<double> fractions;  // of each point of the cut, from below to above
  std::vector<model::Point3> positions;
};

}  // namespace

class Slicer::Impl {
 public:
  Impl(const Hyperplane& hyperplane, OnHyperplane rule, std::shared_ptr<Cutter> cutter)
      : hyperplane_(scaledHyperplane(hyperplane)),
        basis_(basisOf(hyperplane)),
        rule_(rule),
        cutter_(std::move(cutter)) {}

  /// Whether the hyperplane cuts nothing within these bounds. As n.p is computed it never decreases
  /// where it should increase, so this is exact.
  bool misses(const model::Bounds3& bounds, const model::TimeSpan& time) const {
    if (bounds.empty() || !checkHyperplane(hyperplane_)) return false;
    Point4 lowest;
    Point4 highest;
    lowest << bounds.min, time.begin;
    highest << bounds.max, time.end;
    for (int k = 0; k < 4; ++k) {
      if (hyperplane_.normal[k] < 0) std::swap(lowest[k], highest[k]);
    }
    return isAbove(heightOf(lowest)) || !isAbove(heightOf(highest));
  }

  /// Safe to call from several threads at once.
  Result<CutSlab> cut(const Slab& slab) const {
    if (auto checked = checkHyperplane(hyperplane_); !checked) return pass(checked.error());
    if (auto checked = cutter_->check(slab.connectivity); !checked) return pass(checked.error());
    if (auto checked = checkSlab(slab); !checked) return pass(checked.error());
    const std::size_t count = slab.vertices.size();
    std::vector<double> height(count);
    std::vector<std::uint8_t> sides(count);
    for (std::size_t i = 0; i < count; ++i) {
      height[i] = heightOf(slab.vertices[i]);
      sides[i] = (isAbove(height[i]) ? Side::kAbove : 0) | (height[i] == 0 ? Side::kOn : 0);
    }
    CutSlab made;
    made.slab = &slab;
    made.cut = cutter_->cut(slab.connectivity, std::move(sides));
    made.fractions.reserve(made.cut->points.size());
    made.positions.reserve(made.cut->points.size());
    for (const auto& [below, above] : made.cut->points) {
      const double drop = height[below];
      const double fraction = below == above ? 0 : drop / (drop - height[above]);
      const Point4 point =
          slab.vertices[below] + fraction * (slab.vertices[above] - slab.vertices[below]);
      made.fractions.push_back(fraction);
      made.positions.emplace_back(basis_.axes * point);
    }
    return made;
  }

  /// Takes slabs in the order of time.
  void add(const CutSlab& made) {
    const model::Connectivity& connectivity = *made.slab->connectivity;
    const Cut& cut = *made.cut;
    ++slice_.slabsRead;
    if (connectivity.lowerCount != lastUpperCount_) seam_.clear();

    std::vector<std::uint32_t> number(cut.points.size());  // in the slice
    std::vector<std::uint32_t> added;                      // points
    for (std::uint32_t i = 0; i < cut.points.size(); ++i) {
      const auto [below, above] = cut.points[i];
      const bool onSeam = std::max(below, above) < connectivity.lowerCount;
      const auto found = onSeam ? seam_.find(keyOf(below, above)) : seam_.end();
      if (found != seam_.end()) {
        number[i] = found->second;
        continue;
      }
      number[i] = static_cast<std::uint32_t>(slice_.mesh.vertices.size());
      slice_.mesh.vertices.push_back(made.positions[i]);
      added.push_back(i);
    }
    seam_.clear();
    lastUpperCount_ = connectivity.upperCount;
    const std::uint32_t firstUpper = connectivity.firstUpper();
    for (std::uint32_t i = 0; i < cut.points.size(); ++i) {
      const auto [below, above] = cut.points[i];
      if (std::min(below, above) < firstUpper) continue;
      seam_.emplace(keyOf(below - firstUpper, above - firstUpper), number[i]);
    }
    for (const Triangle& triangle : cut.triangles) {
      slice_.mesh.triangles.push_back(
          {number[triangle[0]], number[triangle[1]], number[triangle[2]]});
      if (!basis_.rightHanded) {
        std::swap(slice_.mesh.triangles.back()[1], slice_.mesh.triangles.back()[2]);
      }
    }
    if (!cut.cells.empty()) carryAttributes(made, added);
  }

  /// Instead of the next slab, which the hyperplane misses.
  void skip() {
    ++slice_.slabsSkipped;
    seam_.clear();
    lastUpperCount_ = 0;
  }

  Slice finish() { return std::move(slice_); }

 private:
  static std::uint64_t keyOf(std::uint32_t below, std::uint32_t above) {
    return std::uint64_t{below} << 32U | above;
  }
  double heightOf(const Point4& point) const {
    return along(hyperplane_.normal, point) - hyperplane_.offset;
  }
  bool isAbove(double height) const {
    return rule_ == OnHyperplane::Above ? height >= 0 : height > 0;
  }

  void carryAttributes(const CutSlab& made, const std::vector<std::uint32_t>& added);

  Hyperplane hyperplane_;
  HyperplaneBasis basis_;
  OnHyperplane rule_;
  std::shared_ptr<Cutter> cutter_;
  Slice slice_;
  /// Points on the upper layer of the last slab, by their vertices in the layer.
  std::unordered_map<std::uint64_t, std::uint32_t> seam_;
  std::uint32_t lastUpperCount_ = 0;
  bool hasAttributes_ = false;
};

/// Appends the rows of the new triangles and vertices to the slice's attributes. The first slab
/// that is cut defines them; an attribute that a later slab lacks is lost.
void Slicer::Impl::carryAttributes(const CutSlab& made, const std::vector<std::uint32_t>& added) {
  const Slab& slab = *made.slab;
  std::vector<const Attribute*> given;
  for (const Attribute& attribute : slab.connectivity->cellAttributes) given.push_back(&attribute);
  for (const Attribute& attribute : slab.attributes) given.push_back(&attribute);
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
    if (attribute.domain == Domain::Cell) {
      for (const std::uint32_t cell : made.cut->cells) {
        attribute.values.insert(attribute.values.end(), from.row(cell), from.row(cell) + bytes);
      }
      continue;
    }
    std::vector<std::byte> row(bytes);
    for (const std::uint32_t i : added) {
      const Cut::Point& point = made.cut->points[i];
      std::memcpy(row.data(), from.row(point.below), bytes);
      if (from.type == ScalarType::Float64) {
        interpolate<double>(from.row(point.below), from.row(point.above), made.fractions[i],
                            from.components, row.data());
      } else if (from.type == ScalarType::Float32) {
        interpolate<float>(from.row(point.below), from.row(point.above), made.fractions[i],
                           from.components, row.data());
      }
      attribute.values.insert(attribute.values.end(), row.begin(), row.end());
    }
  }
}

Slicer::Slicer(const Hyperplane& hyperplane, OnHyperplane rule)
    : impl_(std::make_unique<Impl>(hyperplane, rule, std::make_shared<Cutter>())) {}

Slicer::~Slicer() = default;

Result<void> Slicer::put(const Slab& slab) {
  const auto cut = impl_->cut(slab);
  if (!cut) return pass(cut.error());
  impl_->add(*cut);
  return {};
}

Slice Slicer::finish() { return impl_->finish(); }

class TimeSlicer::Impl {
 public:
  explicit Impl(const model::Source& source) : source_(source) {}
  Result<Slice> at(double given) const;

 private:
  const model::Source& source_;
  std::shared_ptr<Cutter> cutter_ = std::make_shared<Cutter>();
};

TimeSlicer::TimeSlicer(const model::Source& source) : impl_(std::make_unique<Impl>(source)) {}

TimeSlicer::~TimeSlicer() = default;

Result<Slice> TimeSlicer::at(double time) const { return impl_->at(time); }

Result<Slice> TimeSlicer::Impl::at(double given) const {
  const model::TimeSpan span = timeSpanOf(source_);
  const auto meant = model::timeWithin(source_, given);
  if (!meant) {
    if (source_.slabCount() == 0) return invalid("the mesh has no slabs");
    return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", given,
                               span.begin, span.end));
  }
  const double time = *meant;
  // The first slab that ends later or, at the very end, the first that ends there.
  const bool atEnd = time == span.end;
  std::size_t low = 0;
  std::size_t high = source_.slabCount();
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    const bool reaches =
        atEnd ? source_.timeSpan(middle).end >= time : source_.timeSpan(middle).end > time;
    if (reaches) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  Slicer::Impl slicer(Hyperplane::atTime(time), atEnd ? OnHyperplane::Above : OnHyperplane::Below,
                      cutter_);
  // Between runs of slabs the solid is empty, and there is nothing to read.
  if (low < source_.slabCount() && source_.timeSpan(low).begin <= time) {
    const auto slab = source_.slab(low);
    if (!slab) return pass(slab.error());
    const auto cut = slicer.cut(**slab);
    if (!cut) return pass(cut.error());
    slicer.add(*cut);
  }
  return slicer.finish();
}

Result<Slice> sliceAtTime(const model::Source& source, double time) {
  return TimeSlicer(source).at(time);
}

namespace {

/// A slab on its way through the threads.
struct OnItsWay {
  std::shared_ptr<const Slab> slab;  // null if it is skipped
  CutSlab cut;
  std::optional<Error> error;
};

}  // namespace

Result<Slice> slice(const model::Source& source, const Hyperplane& hyperplane,
                    const model::Progress& progress) {
  if (auto checked = checkHyperplane(hyperplane); !checked) return pass(checked.error());
  const Eigen::Vector4d& n = hyperplane.normal;
  if (n.head<3>().isZero(0)) return sliceAtTime(source, hyperplane.offset / n[3]);
  Slicer::Impl slicer(hyperplane, OnHyperplane::Below, std::make_shared<Cutter>());
  const std::size_t count = source.slabCount();
  std::optional<Error> error;  // the first one
  std::atomic<bool> failed = false;
  std::size_t next = 0;
  std::size_t done = 0;
  const auto nextIndex = [&](tbb::flow_control& flow) {
    if (next == count || failed) flow.stop();
    return next++;
  };
  const auto cut = [&](std::size_t index) {
    auto item = std::make_shared<OnItsWay>();
    const auto bounds = source.bounds(index);
    if (bounds && slicer.misses(*bounds, source.timeSpan(index))) return item;
    auto slab = source.slab(index);
    if (!slab) {
      item->error = slab.error();
      return item;
    }
    auto made = slicer.cut(**slab);
    if (!made) {
      item->error = made.error();
      return item;
    }
    item->slab = std::move(*slab);
    item->cut = std::move(*made);
    return item;
  };
  const auto add = [&](const std::shared_ptr<OnItsWay>& item) {
    if (error) return;
    if (item->error) {
      error = item->error;
      failed = true;
    } else if (item->slab) {
      slicer.add(item->cut);
    } else {
      slicer.skip();
    }
    ++done;
    if (progress) progress(static_cast<double>(done) / static_cast<double>(count));
  };
  using Item = std::shared_ptr<OnItsWay>;
  tbb::parallel_pipeline(
      static_cast<std::size_t>(tbb::info::default_concurrency()),
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, nextIndex) &
          tbb::make_filter<std::size_t, Item>(tbb::filter_mode::parallel, cut) &
          tbb::make_filter<Item, void>(tbb::filter_mode::serial_in_order, add));
  if (error) return pass(*error);
  return slicer.finish();
}

}  // namespace t4d::convert
