#include "t4d/voxel4d/volumes/zarr_samples.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace t4d::voxel4d {
namespace {

using Numbers = std::vector<std::uint64_t>;

/// Calls `work` with 0 to count - 1, in several threads for requests over a network.
template <class Work>
void forEachRequest(std::size_t count, bool remote, const Work& work) {
  constexpr std::size_t kRequestsInFlight = 8;
  if (!remote) return tbb::parallel_for(std::size_t{0}, count, work);
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> threads;
  while (threads.size() < std::min(count, kRequestsInFlight)) {
    threads.emplace_back([&] {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    });
  }
}

/// The first error of several pieces of work, by their order.
Result<void> firstError(std::vector<Result<void>>& results) {
  for (Result<void>& result : results) {
    if (!result) return std::move(result);
  }
  return {};
}

/// The number along each axis of number i of a box, the last axis fastest.
Numbers numbersOf(std::uint64_t i, const Numbers& sizes) {
  Numbers numbers(sizes.size());
  for (std::size_t axis = sizes.size(); axis-- > 0; i /= sizes[axis]) {
    numbers[axis] = i % sizes[axis];
  }
  return numbers;
}

std::uint64_t product(const Numbers& sizes) {
  return std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{1}, std::multiplies<>());
}

/// A box of samples in two arrays.
struct Copy {
  Numbers sizes;  ///< along each axis
  Numbers from;   ///< steps along each axis, in samples
  Numbers to;
};

template <std::size_t Size>
void copyRow(const std::byte* from, std::uint64_t step, std::byte* to, std::uint64_t toStep,
             std::uint64_t count) {
  for (std::uint64_t i = 0; i < count; ++i) {
    std::memcpy(to + i * toStep * Size, from + i * step * Size, Size);
  }
}

void copyRow(std::size_t size, const std::byte* from, std::uint64_t step, std::byte* to,
             std::uint64_t toStep, std::uint64_t count) {
  if (step == 1 && toStep == 1) {
    std::memcpy(to, from, count * size);
  } else if (size == 1) {
    copyRow<1>(from, step, to, toStep, count);
  } else if (size == 2) {
    copyRow<2>(from, step, to, toStep, count);
  } else if (size == 4) {
    copyRow<4>(from, step, to, toStep, count);
  } else {
    copyRow<8>(from, step, to, toStep, count);
  }
}

/// Copies samples of `size` bytes, in rows along `fast`.
void copyBox(const Copy& copy, std::size_t fast, std::size_t size, const std::byte* from,
             std::byte* to) {
  Numbers at(copy.sizes.size(), 0);  // the first of a row
  for (std::size_t axis = 0; axis < at.size();) {
    copyRow(size, from, copy.from[fast], to, copy.to[fast], copy.sizes[fast]);
    for (axis = 0; axis < at.size(); ++axis) {
      if (axis == fast) continue;
      from += copy.from[axis] * size;
      to += copy.to[axis] * size;
      if (++at[axis] < copy.sizes[axis]) break;
      from -= copy.from[axis] * copy.sizes[axis] * size;
      to -= copy.to[axis] * copy.sizes[axis] * size;
      at[axis] = 0;
    }
  }
}

/// Where the chunks in a shard are, as its index says.
class ShardIndexes {
 public:
  struct Entry {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
  };

  /// Nothing if there is no such chunk.
  Result<std::optional<Entry>> find(const ZarrStore& store, const ZarrShards& shards,
                                    const std::string& key, std::uint64_t number) {
    const std::unique_lock lock(mutex_);
    auto index = indexes_.find(key);
    if (index == indexes_.end()) {
      auto bytes = load(store, shards, key);
      if (!bytes) return bytes.error();
      constexpr std::uint64_t kMostKept = std::uint64_t{64} << 20U;
      kept_ += bytes->size();
      if (kept_ > kMostKept) indexes_.clear(), kept_ = bytes->size();
      index = indexes_.emplace(key, std::move(*bytes)).first;
    }
    if (index->second.empty()) return std::nullopt;
    const auto numberAt = [&](std::uint64_t at) {
      std::uint64_t value = 0;
      static_assert(std::endian::native == std::endian::little);
      std::memcpy(&value, index->second.data() + at, sizeof value);
      return value;
    };
    const Entry entry = {numberAt(16 * number), numberAt(16 * number + 8)};
    constexpr std::uint64_t kNone = ~std::uint64_t{0};
    if (entry.offset == kNone && entry.bytes == kNone) return std::nullopt;
    constexpr std::uint64_t kMost = std::uint64_t{1} << 62U;
    if (entry.offset > kMost || entry.bytes > kMost || entry.bytes == 0) {
      return invalid(fmt::format("its index places chunk {} at byte {}, with {} bytes", number,
                                 entry.offset, entry.bytes),
                     store.nameOf(key));
    }
    return entry;
  }

 private:
  /// The index without its checksum; empty if there is no file.
  static Result<std::string> load(const ZarrStore& store, const ZarrShards& shards,
                                  const std::string& key) {
    const std::uint64_t size = shards.indexBytes();
    const ZarrPart part = shards.indexAtEnd ? ZarrPart{size, size, true} : ZarrPart{0, size};
    auto bytes = store.read(key, part);
    if (!bytes) return bytes.error();
    if (!*bytes) return std::string();
    constexpr std::array kChecked = {ZarrCodec::Crc32c};
    if (!shards.indexChecked) return std::move(**bytes);
    auto index = unpackZarrChunk(std::move(**bytes), kChecked, size - 4);
    if (!index) return invalid("its index is damaged: the checksum is wrong", store.nameOf(key));
    return index;
  }

  std::mutex mutex_;
  std::map<std::string, std::string> indexes_;
  std::uint64_t kept_ = 0;
};

class ZarrReader : public SampleReader {
 public:
  ZarrReader(std::shared_ptr<const ZarrSamples> samples, std::vector<ZarrRange> ranges)
      : samples_(std::move(samples)), ranges_(std::move(ranges)) {
    const std::size_t channel = samples_->axes.find('c');
    if (channel != std::string::npos) ranges_[channel] = {samples_->channel, 1};
    steps_.assign(ranges_.size(), 0);
    std::uint64_t step = 1;
    for (const char axis : spaceAxes(*samples_)) {
      const std::size_t at = samples_->axes.find(axis);
      if (step == 1) fast_ = at;
      steps_[at] = step;
      step *= ranges_[at].count;
    }
    frameBytes_ = step * size();
    time_ = samples_->axes.find('t');
    if (time_ == std::string::npos) return;
    steps_[time_] = step;
  }

  Result<void> read(std::span<std::byte> into) override {
    for (; !into.empty(); into = into.subspan(frameBytes_), ++next_) {
      if (auto done = readFrame(into.first(frameBytes_)); !done) return done;
    }
    return {};
  }
  Result<void> skip(std::uint64_t bytes) override {
    next_ += bytes / frameBytes_;
    return {};
  }
  Result<void> finish(bool) override { return {}; }

 private:
  const ZarrArray& array() const { return samples_->array; }
  std::size_t size() const { return sizeOf(array().type); }

  /// Of all frames, that number `next_` of those that are read.
  ZarrRange batch() const {
    if (time_ == std::string::npos) return {0, 1};
    constexpr std::uint64_t kMostKept = std::uint64_t{256} << 20U;
    const std::uint64_t most = std::max<std::uint64_t>(1, kMostKept / frameBytes_);
    const std::uint64_t first = ranges_[time_].first + next_;
    const std::uint64_t end = std::min(ranges_[time_].first + ranges_[time_].count,
                                       (first / array().chunk[time_] + 1) * array().chunk[time_]);
    return {first, std::min(end - first, most)};
  }

  Result<void> readFrame(std::span<std::byte> into) {
    if (next_ - keptFirst_ >= keptCount_) {
      const ZarrRange frames = batch();
      if (frames.count == 1) return readFrames(frames, into);
      keptCount_ = 0;
      kept_.resize(frames.count * frameBytes_);
      if (auto done = readFrames(frames, kept_); !done) return done;
      keptFirst_ = next_;
      keptCount_ = frames.count;
    }
    const std::byte* from = kept_.data() + (next_ - keptFirst_) * frameBytes_;
    std::memcpy(into.data(), from, frameBytes_);
    return {};
  }

  /// Frames that are in one chunk along the axis of time.
  Result<void> readFrames(const ZarrRange& frames, std::span<std::byte> into) {
    std::vector<ZarrRange> ranges = ranges_;
    if (time_ != std::string::npos) ranges[time_] = frames;
    Numbers first;
    Numbers counts;
    for (std::size_t axis = 0; axis < ranges.size(); ++axis) {
      first.push_back(ranges[axis].first / array().chunk[axis]);
      counts.push_back((ranges[axis].first + ranges[axis].count - 1) / array().chunk[axis] -
                       first[axis] + 1);
    }
    const std::uint64_t chunks = product(counts);
    constexpr std::uint64_t kMostInFlight = std::uint64_t{64} << 20U;
    constexpr std::uint64_t kMostAtATime = 64;
    const std::uint64_t atATime =
        std::clamp<std::uint64_t>(kMostInFlight / array().chunkBytes(), 1, kMostAtATime);
    for (std::uint64_t begin = 0; begin < chunks; begin += atATime) {
      std::vector<Numbers> numbers;
      for (std::uint64_t i = begin; i < std::min(chunks, begin + atATime); ++i) {
        numbers.push_back(numbersOf(i, counts));
        for (std::size_t axis = 0; axis < first.size(); ++axis) numbers.back()[axis] += first[axis];
      }
      if (auto done = readChunks(numbers, ranges, into); !done) return done;
    }
    return {};
  }

  Result<void> readChunks(const std::vector<Numbers>& numbers, const std::vector<ZarrRange>& ranges,
                          std::span<std::byte> into) {
    std::vector<std::optional<std::string>> packed(numbers.size());
    std::vector<Result<void>> results(numbers.size());
    forEachRequest(numbers.size(), samples_->store->remote(), [&](std::size_t i) {
      auto bytes = load(numbers[i]);
      if (bytes) {
        packed[i] = std::move(*bytes);
      } else {
        results[i] = bytes.error();
      }
    });
    if (auto done = firstError(results); !done) return done;
    tbb::parallel_for(std::size_t{0}, numbers.size(), [&](std::size_t i) {
      results[i] = place(numbers[i], std::move(packed[i]), ranges, into);
    });
    samples_->counts->chunks += numbers.size();
    return firstError(results);
  }

  /// The file of a chunk: itself, or a shard, and its number in that.
  std::pair<std::string, std::uint64_t> fileOf(const Numbers& chunk) const {
    if (!array().shards) return {array().key(chunk), 0};
    Numbers shard;
    std::uint64_t number = 0;
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      const std::uint64_t chunks = array().shards->chunks[axis];
      shard.push_back(chunk[axis] / chunks);
      number = number * chunks + chunk[axis] % chunks;
    }
    return {array().key(shard), number};
  }

  Result<std::optional<std::string>> load(const Numbers& chunk) {
    const std::uint64_t most = mostPackedBytes(array().codecs, array().chunkBytes());
    const auto [key, number] = fileOf(chunk);
    if (!array().shards) return samples_->store->read(key, most);
    const auto entry = indexes_.find(*samples_->store, *array().shards, key, number);
    if (!entry) return entry.error();
    if (!*entry) return std::nullopt;
    if ((*entry)->bytes > most) {
      return invalid(fmt::format("its index says that chunk {} has {} bytes; at most {} are "
                                 "expected",
                                 number, (*entry)->bytes, most),
                     samples_->store->nameOf(key));
    }
    return samples_->store->read(key, {(*entry)->offset, (*entry)->bytes});
  }

  Result<void> place(const Numbers& chunk, std::optional<std::string> packed,
                     const std::vector<ZarrRange>& ranges, std::span<std::byte> into) const {
    Copy copy{{}, array().chunkStride, steps_};
    std::uint64_t from = 0;
    std::uint64_t to = 0;
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      const std::uint64_t begin = chunk[axis] * array().chunk[axis];
      const ZarrRange& range = ranges[axis];
      const std::uint64_t first = std::max(begin, range.first);
      const std::uint64_t end = std::min(begin + array().chunk[axis], range.first + range.count);
      copy.sizes.push_back(end - first);
      from += (first - begin) * array().chunkStride[axis];
      to += (first - range.first) * steps_[axis];
    }
    std::byte* const target = into.data() + to * size();
    if (!packed) {
      ++samples_->counts->missing;
      std::ranges::fill(copy.from, 0);
      std::array<std::byte, 8> fill = array().fill;
      copyBox(copy, fast_, size(), fill.data(), target);
      return {};
    }
    auto bytes = unpackZarrChunk(std::move(*packed), array().codecs, array().chunkBytes());
    if (!bytes) {
      Error error = bytes.error();
      const auto [key, number] = fileOf(chunk);
      error.where = samples_->store->nameOf(key);
      if (array().shards) error.message = fmt::format("chunk {}: {}", number, error.message);
      return error;
    }
    putInOrder(*bytes);
    const std::string samples = array().half ? floatsOf(*bytes) : std::move(*bytes);
    copyBox(copy, fast_, size(), reinterpret_cast<const std::byte*>(samples.data()) + from * size(),
            target);
    return {};
  }

  /// Samples in the order of this machine.
  void putInOrder(std::string& bytes) const {
    const std::size_t stored = array().storedSize();
    if (array().order == std::endian::native || stored == 1) return;
    for (std::size_t i = 0; i < bytes.size(); i += stored) {
      std::reverse(bytes.data() + i, bytes.data() + i + stored);
    }
  }

  static std::string floatsOf(const std::string& halves) {
    std::string floats(halves.size() * 2, '\0');
    for (std::size_t i = 0; i < halves.size(); i += 2) {
      Eigen::half half;
      std::memcpy(&half, halves.data() + i, sizeof half);
      const auto value = static_cast<float>(half);
      std::memcpy(floats.data() + 2 * i, &value, sizeof value);
    }
    return floats;
  }

  std::shared_ptr<const ZarrSamples> samples_;
  std::vector<ZarrRange> ranges_;
  Numbers steps_;  // in samples of the frames that are read, along each axis
  std::size_t fast_ = 0;
  std::size_t time_ = std::string::npos;
  std::uint64_t frameBytes_ = 0;
  std::uint64_t next_ = 0;
  std::vector<std::byte> kept_;
  std::uint64_t keptFirst_ = 0;
  std::uint64_t keptCount_ = 0;
  ShardIndexes indexes_;
};

}  // namespace

std::unique_ptr<SampleReader> openZarrSamples(std::shared_ptr<const ZarrSamples> samples,
                                              std::vector<ZarrRange> ranges) {
  return std::make_unique<ZarrReader>(std::move(samples), std::move(ranges));
}

std::unique_ptr<SampleReader> openZarrSamples(std::shared_ptr<const ZarrSamples> samples) {
  std::vector<ZarrRange> ranges;
  for (const std::uint64_t size : samples->array.shape) ranges.push_back({0, size});
  return openZarrSamples(std::move(samples), std::move(ranges));
}

std::string spaceAxes(const ZarrSamples& samples) {
  std::string space;
  for (const char axis : samples.axes) {
    if (axis != 't' && axis != 'c') space += axis;
  }
  std::ranges::sort(space, {},
                    [&](char axis) { return samples.array.chunkStride[samples.axes.find(axis)]; });
  return space;
}

std::string zarrNotice(const ZarrCounts& counts) {
  if (counts.missing == 0) return {};
  return fmt::format("{} of {} chunks have no file; their samples have the fill value",
                     counts.missing.load(), counts.chunks.load());
}

}  // namespace t4d::voxel4d
