#include "voxel4d/volumes/region_reader.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace t4d::voxel4d {
namespace {

/// An axis of the samples in a file.
struct FileAxis {
  std::uint64_t stored = 1;  // samples
  std::uint64_t first = 0;   // that is read
  std::uint64_t count = 1;   // that are read
};

/// The one that varies fastest first; each file of several has one frame, so time is not among
/// them.
std::vector<FileAxis> axesOf(const Volume& volume) {
  std::vector<FileAxis> axes;
  for (std::size_t i = 0; i < volume.sizes.size(); ++i) {
    if (volume.data.size() > 1 && volume.axes[i] == 't') continue;
    const StoredAxis stored =
        volume.stored.empty() ? StoredAxis{volume.sizes[i], 0} : volume.stored[i];
    axes.push_back({stored.size, stored.first, volume.sizes[i]});
  }
  return axes;
}

/// Reads the runs of a region, samples that follow one another, and skips what is between them.
class RegionReader : public SampleReader {
 public:
  RegionReader(std::unique_ptr<SampleReader> all, const std::vector<FileAxis>& axes,
               std::uint64_t sampleBytes)
      : all_(std::move(all)), run_(sampleBytes), whole_(sampleBytes) {
    bool isWhole = true;
    for (const FileAxis& axis : axes) {
      if (isWhole) {
        begin_ = axis.first * whole_;
        run_ = axis.count * whole_;
        isWhole = axis.count == axis.stored;
      } else {
        steps_.push_back({whole_, axis});
      }
      whole_ *= axis.stored;
    }
  }

  Result<void> read(std::span<std::byte> into) override {
    return inRuns(into.size(), [&](std::uint64_t bytes) {
      auto done = all_->read(into.first(bytes));
      into = into.subspan(bytes);
      return done;
    });
  }
  Result<void> skip(std::uint64_t bytes) override {
    return inRuns(bytes, [&](std::uint64_t part) { return all_->skip(part); });
  }
  Result<void> finish(bool mayHaveMore) override {
    if (auto done = all_->skip(whole_ - at_); !done) return done;
    return all_->finish(mayHaveMore);
  }

 private:
  /// Calls `take` with the bytes of each run, of so many bytes from here on.
  template <class Take>
  Result<void> inRuns(std::uint64_t bytes, Take take) {
    while (bytes > 0) {
      if (left_ == 0) {
        if (auto there = goToNextRun(); !there) return there;
      }
      const std::uint64_t part = std::min(bytes, left_);
      if (auto done = take(part); !done) return done;
      at_ += part;
      left_ -= part;
      bytes -= part;
    }
    return {};
  }

  struct Step {
    std::uint64_t bytes = 0;  // to the next sample along the axis
    FileAxis axis;
  };

  Result<void> goToNextRun() {
    std::uint64_t to = begin_;
    std::uint64_t number = next_++;
    for (const auto& [bytes, axis] : steps_) {
      to += (axis.first + number % axis.count) * bytes;
      number /= axis.count;
    }
    if (auto done = all_->skip(to - at_); !done) return done;
    at_ = to;
    left_ = run_;
    return {};
  }

  std::unique_ptr<SampleReader> all_;
  std::uint64_t begin_ = 0;  // bytes from a multiple of all steps to its run
  std::uint64_t run_;        // bytes
  std::vector<Step> steps_;  // from run to run, the fastest axis first
  std::uint64_t whole_;      // bytes of all samples
  std::uint64_t at_ = 0;
  std::uint64_t left_ = 0;  // of the run
  std::uint64_t next_ = 0;  // the number of the next run
};

}  // namespace

Result<std::unique_ptr<SampleReader>> openRegion(const Volume& volume, const SampleData& data) {
  // A stream contains the region only.
  if (data.encoding == SampleEncoding::Stream) return openSamples(data, volume.type, 0);
  const std::vector<FileAxis> axes = axesOf(volume);
  std::uint64_t bytes = sizeOf(volume.type);
  for (const FileAxis& axis : axes) bytes *= axis.stored;
  auto all = openSamples(data, volume.type, data.begin + bytes);
  if (!all) return all;
  if (auto done = (*all)->skip(data.begin); !done) return done.error();
  if (volume.stored.empty()) return all;
  return std::make_unique<RegionReader>(std::move(*all), axes, sizeOf(volume.type));
}

}  // namespace t4d::voxel4d
