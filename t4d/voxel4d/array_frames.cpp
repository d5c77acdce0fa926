#include "t4d/voxel4d/array_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace t4d::voxel4d {
namespace {

template <class T>
class ArrayFrames : public FrameSource {
 public:
  ArrayFrames(std::span<const ArrayFrame<T>> frames, const ArrayOptions& options)
      : frames_(frames.begin(), frames.end()),
        size_(options.size),
        lattice_(options.lattice),
        sign_(options.iso ? -1 : 1),
        iso_(options.iso.value_or(0)) {
    for (int axis = 0; axis < 3; ++axis)
      blocks_[axis] = (size_[axis] + kBlockSize - 1) / kBlockSize;
  }

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return frames_.size(); }

  /// `most` is the largest distance of a field value from zero; points outside the arrays get that
  /// distance.
  Result<void> setOutside(double most) {
    outside_ = static_cast<T>(iso_ + sign_ * (most > 0 ? most : 1));
    outsideValue_ = field(outside_);
    if (outsideValue_ > 0 && std::isfinite(outsideValue_)) return {};
    return invalid(fmt::format("the values differ from the iso value {} by too little", iso_));
  }

  Result<Frame> frame(std::size_t index) override {
    const ArrayFrame<T>& given = frames_[index];
    const std::size_t count = blocks_[0] * blocks_[1] * blocks_[2];
    std::vector<Block> blocks(count);
    const auto memory = std::make_shared<std::vector<std::array<T, 512>>>(kHasValues ? count : 0);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      fill(given.values, i, blocks[i], kHasValues ? (*memory)[i].data() : nullptr);
    });
    Frame frame;
    frame.time = given.time;
    if constexpr (kHasValues) {
      frame.outsideValue = outsideValue_;
      frame.owner = memory;
      frame.blocks = std::move(blocks);
    } else {
      for (const Block& block : blocks) {
        const auto all = [&](std::uint64_t word) {
          return std::ranges::all_of(block.inside, [&](std::uint64_t w) { return w == word; });
        };
        if (all(kAllBits)) {
          frame.tiles.push_back({block.coord, 1, 0});
        } else if (!all(0)) {
          frame.blocks.push_back(block);
        }
      }
    }
    return frame;
  }

 private:
  static constexpr bool kHasValues = !std::is_same_v<T, bool>;

  double field(T value) const { return sign_ * (static_cast<double>(value) - iso_); }
  bool isInside(T value) const {
    if constexpr (kHasValues) return field(value) < 0;
    return value;
  }

  /// Fills block number `index` and, if there are values, those of its 512 points.
  void fill(std::span<const T> values, std::size_t index, Block& block, T* into) const {
    const std::array<std::size_t, 3> at = {index / blocks_[2] / blocks_[1],
                                           index / blocks_[2] % blocks_[1], index % blocks_[2]};
    block.coord = {static_cast<std::int32_t>(at[0]), static_cast<std::int32_t>(at[1]),
                   static_cast<std::int32_t>(at[2])};
    for (std::size_t i = 0; i < 512; ++i) {
      const std::size_t x = kBlockSize * at[0] + i / 64;
      const std::size_t y = kBlockSize * at[1] + i / 8 % 8;
      const std::size_t z = kBlockSize * at[2] + i % 8;
      const bool given = x < size_[0] && y < size_[1] && z < size_[2];
      const T value = given ? values[(x * size_[1] + y) * size_[2] + z] : outside_;
      if (isInside(value)) block.inside[i / 64] |= std::uint64_t{1} << (i % 64);
      if (into != nullptr) into[i] = value;
    }
    if constexpr (std::is_same_v<T, float>) {
      block.values = {into, nullptr, sign_, iso_};
    } else if constexpr (std::is_same_v<T, double>) {
      block.values = {nullptr, into, sign_, iso_};
    }
  }

  std::vector<ArrayFrame<T>> frames_;
  std::array<std::size_t, 3> size_;
  std::array<std::size_t, 3> blocks_{};
  Lattice lattice_;
  double sign_;  // the field is sign * (value - iso)
  double iso_;
  T outside_ = {};
  double outsideValue_ = 0;
};

Result<std::size_t> pointCount(const std::array<std::size_t, 3>& size) {
  std::size_t count = 1;
  for (const std::size_t points : size) {
    if (points == 0 || points > std::numeric_limits<std::int32_t>::max() ||
        count > std::numeric_limits<std::size_t>::max() / points) {
      return invalid(
          fmt::format("the size of the arrays is {} x {} x {}", size[0], size[1], size[2]));
    }
    count *= points;
  }
  return count;
}

}  // namespace

template <class T>
Result<std::unique_ptr<FrameSource>> arrayFrames(std::span<const ArrayFrame<T>> frames,
                                                 const ArrayOptions& options) {
  const auto points = pointCount(options.size);
  if (!points) return pass(points.error());
  const Lattice& lattice = options.lattice;
  if (!(lattice.voxelSize > 0) || !std::isfinite(lattice.voxelSize) ||
      !lattice.origin.allFinite()) {
    return invalid(fmt::format("the voxel size is {}, the origin ({}, {}, {})", lattice.voxelSize,
                               lattice.origin[0], lattice.origin[1], lattice.origin[2]));
  }
  if (options.iso && (std::is_same_v<T, bool> || !std::isfinite(*options.iso))) {
    return invalid(fmt::format(
        "the iso value is {}; expected is a finite number, and none for bools", *options.iso));
  }
  const double iso = options.iso.value_or(0);
  double most = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto values = frames[i].values;
    if (values.size() != *points) {
      return invalid(
          fmt::format("the array has {} values where {} x {} x {} = {} are expected", values.size(),
                      options.size[0], options.size[1], options.size[2], *points),
          fmt::format("frame {}", i));
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double distance = std::abs(static_cast<double>(values[k]) - iso);
      if (!std::isfinite(distance)) {
        return invalid(fmt::format("value {} is {}", k, static_cast<double>(values[k])),
                       fmt::format("frame {}", i));
      }
      most = std::max(most, distance);
    }
  }
  auto source = std::make_unique<ArrayFrames<T>>(frames, options);
  if constexpr (!std::is_same_v<T, bool>) {
    if (auto set = source->setOutside(most); !set) return pass(set.error());
  }
  return source;
}

template Result<std::unique_ptr<FrameSource>> arrayFrames<float>(
    std::span<const ArrayFrame<float>> frames, const ArrayOptions& options);
template Result<std::unique_ptr<FrameSource>> arrayFrames<double>(
    std::span<const ArrayFrame<double>> frames, const ArrayOptions& options);
template Result<std::unique_ptr<FrameSource>> arrayFrames<bool>(
    std::span<const ArrayFrame<bool>> frames, const ArrayOptions& options);

}  // namespace t4d::voxel4d
