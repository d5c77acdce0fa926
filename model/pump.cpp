#include <algorithm>
#include <utility>

#include "model/parallel.h"
#include "model/progress.h"
#include "t4d/mesh.h"

namespace t4d::model {
namespace {

/// One thread reads, another puts.
constexpr std::size_t kFewSlabs = 2;
/// A slab with more vertices is large, whatever its cells.
constexpr std::size_t kManyVertices = std::size_t{1} << 20;

std::size_t atOnceOf(const Source& source) {
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < source.slabCount(); ++i) {
    const auto cells = source.cellCount(i);
    if (!cells) return std::min(kFewSlabs, threadCount());
    most = std::max(most, *cells);
  }
  return std::max(slabsAtOnce(most), std::min(kFewSlabs, threadCount()));
}

struct Item {
  Result<std::shared_ptr<const Slab>> slab;
  bool isPrepared = false;
  std::unique_ptr<Sink::Prepared> prepared;

  void prepare(const Sink& sink) {
    if (!std::exchange(isPrepared, true)) prepared = sink.prepare(**slab);
  }
  /// The results of large slabs are made one after another.
  bool isLarge() const {
    const auto& connectivity = (*slab)->connectivity;
    return (*slab)->vertices.size() > kManyVertices ||
           (connectivity && connectivity->cells.size() > kCellsAtOnce);
  }
};

}  // namespace

Result<void> pump(const Source& source, Sink& sink, const Progress& progress) {
  const std::size_t count = source.slabCount();
  std::size_t atOnce = atOnceOf(source);
  std::size_t done = 0;
  Result<void> result;
  while (result && done < count) {
    const std::size_t first = done;
    // One after another, so that parts that slabs share are read once.
    const auto read = [&](std::size_t number) {
      auto item = std::make_shared<Item>();
      item->slab = source.slab(first + number);
      return item;
    };
    const auto make = [&](std::shared_ptr<Item> item) {
      if (item->slab && !item->isLarge()) item->prepare(sink);
      return item;
    };
    const auto take = [&](const std::shared_ptr<Item>& item) {
      if (!item->slab) {
        result = item->slab.error();
        return false;
      }
      item->prepare(sink);
      result = sink.putPrepared(**item->slab, item->prepared.get());
      if (!result) return false;
      ++done;
      result = report(progress, done, count);
      if (!result) return false;
      // More than two of these are not meant to be in memory.
      if (!item->isLarge() || atOnce <= kFewSlabs) return true;
      atOnce = kFewSlabs;
      return false;
    };
    inOrder<std::shared_ptr<Item>, std::shared_ptr<Item>>(count - first, atOnce, read, make, take);
  }
  return result;
}

}  // namespace t4d::model
