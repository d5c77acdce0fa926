#include "voxel4d/volumes/volume_labels.h"

#include <cmath>
#include <set>

#include <fmt/format.h>

#include "voxel4d/sample_box.h"

namespace t4d::voxel4d {
namespace {

/// Doubles are exact for whole numbers up to this.
constexpr double kLargestLabel = 9007199254740992;

/// Labels found so far.
class LabelSet {
 public:
  /// Adds the labels of a frame, block by block: its samples may lie in memory in any order.
  Result<void> add(const Frame& frame, const std::array<std::uint64_t, 3>& sizes,
                   const Place& where) {
    const auto end = [&](std::size_t axis) { return static_cast<std::int32_t>(sizes[axis]); };
    for (Coord block; block.x * kBlockSize < end(0); ++block.x) {
      for (block.y = 0; block.y * kBlockSize < end(1); ++block.y) {
        for (block.z = 0; block.z * kBlockSize < end(2); ++block.z) {
          for (unsigned index = 0; index < 512; ++index) {
            const Coord point{block.x * kBlockSize + static_cast<std::int32_t>(index >> 6U),
                              block.y * kBlockSize + static_cast<std::int32_t>(index >> 3U & 7U),
                              block.z * kBlockSize + static_cast<std::int32_t>(index & 7U)};
            if (point.x >= end(0) || point.y >= end(1) || point.z >= end(2)) continue;
            if (auto added = add(frame.samples->at(block, index), point, where); !added) {
              return added;
            }
          }
        }
      }
    }
    return {};
  }

  const std::set<double>& labels() const { return labels_; }

 private:
  Result<void> add(double value, const Coord& point, const Place& where) {
    if (value == last_) return {};
    last_ = value;
    if (value == 0) return {};
    if (value != std::trunc(value) || std::abs(value) > kLargestLabel) {
      return invalid(
          fmt::format("has the sample {} at ({}, {}, {}); labels are whole numbers up to 2^53",
                      value, point.x, point.y, point.z),
          where);
    }
    labels_.insert(value);
    if (labels_.size() <= kMostLabels) return {};
    return invalid(
        fmt::format("has more than {} different samples, so they are not labels", kMostLabels),
        where, Remedy::IsoValue);
  }

  std::set<double> labels_;
  double last_ = 0;  // most samples equal their neighbour
};

}  // namespace

Result<std::vector<std::int64_t>> labelsOf(std::span<const std::filesystem::path> files,
                                           const VolumeOptions& options) {
  VolumeOptions how = options;
  how.valuesAlone = true;
  how.iso.reset();
  how.label.reset();
  how.outside.reset();
  const auto opened = openVolumeFrames(files, how);
  if (!opened) return opened.error();
  FrameSource& frames = *opened->frames;
  LabelSet found;
  for (std::size_t i = 0; i < frames.frameCount(); ++i) {
    const auto frame = frames.frame(i);
    if (!frame) return frame.error();
    if (auto added = found.add(*frame, opened->sizes, frames.placeOf(i)); !added) {
      return added.error();
    }
  }
  const std::set<double>& labels = found.labels();
  if (labels.empty()) {
    return invalid("has no label: all samples of all frames are 0", frames.placeOf(0).file);
  }
  return std::vector<std::int64_t>(labels.begin(), labels.end());
}

}  // namespace t4d::voxel4d
