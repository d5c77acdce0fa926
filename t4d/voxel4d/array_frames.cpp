#include "t4d/voxel4d/array_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "t4d/voxel4d/array_frame.h"

namespace t4d::voxel4d {
namespace {

template <class T>
class ArrayFrames : public FrameSource {
 public:
  ArrayFrames(std::span<const ArrayFrame<T>> frames, const ArrayOptions& options,
              const ArrayField& field)
      : frames_(frames.begin(), frames.end()),
        shape_{options.size},
        lattice_(options.lattice),
        field_(field) {}

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return frames_.size(); }
  Result<Frame> frame(std::size_t index) override {
    return frameOfArray(frames_[index].values, shape_, field_, frames_[index].time);
  }

 private:
  std::vector<ArrayFrame<T>> frames_;
  ArrayShape shape_;
  Lattice lattice_;
  ArrayField field_;
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
  ArrayField field;
  if (options.iso) field = {-1, *options.iso};
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
      const double distance = std::abs(field(values[k]));
      if (!std::isfinite(distance)) {
        const std::size_t ny = options.size[1];
        const std::size_t nz = options.size[2];
        return invalid(fmt::format("the value at ({}, {}, {}) is {}", k / nz / ny, k / nz % ny,
                                   k % nz, static_cast<double>(values[k])),
                       fmt::format("frame {}", i));
      }
      most = std::max(most, distance);
    }
  }
  if constexpr (!std::is_same_v<T, bool>) {
    if (auto set = field.template setOutside<T>(most); !set) return pass(set.error());
  }
  return std::make_unique<ArrayFrames<T>>(frames, options, field);
}

template Result<std::unique_ptr<FrameSource>> arrayFrames<float>(
    std::span<const ArrayFrame<float>> frames, const ArrayOptions& options);
template Result<std::unique_ptr<FrameSource>> arrayFrames<double>(
    std::span<const ArrayFrame<double>> frames, const ArrayOptions& options);
template Result<std::unique_ptr<FrameSource>> arrayFrames<bool>(
    std::span<const ArrayFrame<bool>> frames, const ArrayOptions& options);

}  // namespace t4d::voxel4d
