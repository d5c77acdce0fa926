#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "model/voxel_size.h"
#include "t4d/frames.h"
#include "voxel4d/sample_box.h"

namespace t4d::voxel4d {
namespace {

template <class T>
constexpr SampleType kTypeOf = std::is_same_v<T, bool>    ? SampleType::Bool
                               : std::is_same_v<T, float> ? SampleType::Float32
                                                          : SampleType::Float64;

template <class T>
SampleBox boxOf(const ArrayFrame<T>& frame, const std::array<std::size_t, 3>& size) {
  const auto stride = [](std::size_t values) {
    return static_cast<std::ptrdiff_t>(values * sizeof(T));
  };
  return {kTypeOf<T>,
          reinterpret_cast<const std::byte*>(frame.values.data()),
          size,
          {stride(size[1] * size[2]), stride(size[2]), stride(1)}};
}

template <class T>
class ArrayFrames : public FrameSource {
 public:
  ArrayFrames(std::span<const ArrayFrame<T>> frames, const ArrayOptions& options,
              const SampleRule& rule, double outside)
      : frames_(frames.begin(), frames.end()), options_(options), rule_(rule), outside_(outside) {}

  const Lattice& lattice() const override { return options_.lattice; }
  std::size_t frameCount() const override { return frames_.size(); }
  Result<Frame> frame(std::size_t index) override {
    const SampleBox box = boxOf(frames_[index], options_.size);
    return frameOf(box, rule_, signsOf(box, rule_), outside_, frames_[index].time, nullptr);
  }

 private:
  std::vector<ArrayFrame<T>> frames_;
  ArrayOptions options_;
  SampleRule rule_;
  double outside_;
};

}  // namespace

template <class T>
Result<std::unique_ptr<FrameSource>> arrayFrames(std::span<const ArrayFrame<T>> frames,
                                                 const ArrayOptions& options) {
  if (auto checked = checkArraySize(options.size); !checked) return checked.error();
  const std::size_t points = options.size[0] * options.size[1] * options.size[2];
  const Lattice& lattice = options.lattice;
  if (auto sized = model::checkVoxelSize(lattice.voxelSize); !sized) return sized.error();
  if (!lattice.origin.allFinite()) {
    return invalid(fmt::format("the origin is ({}, {}, {}); it must be finite", lattice.origin[0],
                               lattice.origin[1], lattice.origin[2]));
  }
  const auto rule = arrayRule(kTypeOf<T>, "", ArrayInside{.iso = options.iso});
  if (!rule) return rule.error();
  double farthest = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto values = frames[i].values;
    const auto ofFrame = [i] { return placeIn({}, fmt::format("frame {}", i)); };
    if (values.size() != points) {
      return invalid(
          fmt::format("the array has {} values where {} x {} x {} = {} are expected", values.size(),
                      options.size[0], options.size[1], options.size[2], points),
          ofFrame());
    }
    if (rule->mask) continue;
    const auto signs = usableSignsOf(boxOf(frames[i], options.size), *rule);
    if (!signs) return invalid(signs.error().message, ofFrame());
    farthest = std::max(farthest, signs->farthest);
  }
  const auto outside = fieldOutside(*rule, farthest);
  if (!outside) return outside.error();
  return std::make_unique<ArrayFrames<T>>(frames, options, *rule, *outside);
}

template Result<std::unique_ptr<FrameSource>> arrayFrames<float>(
    std::span<const ArrayFrame<float>> frames, const ArrayOptions& options);
template Result<std::unique_ptr<FrameSource>> arrayFrames<double>(
    std::span<const ArrayFrame<double>> frames, const ArrayOptions& options);
template Result<std::unique_ptr<FrameSource>> arrayFrames<bool>(
    std::span<const ArrayFrame<bool>> frames, const ArrayOptions& options);

}  // namespace t4d::voxel4d
