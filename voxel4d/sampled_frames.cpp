#include "voxel4d/sampled_frames.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "model/parallel.h"
#include "voxel4d/occupancy.h"

namespace t4d::voxel4d {

using model::Point3;

namespace {

/// Edge length, in blocks, of the cubes that threads process one at a time; one sample may decide a
/// whole cube.
constexpr std::int32_t kLargestCube = 16;

struct Samples {
  std::vector<std::array<double, 512>> doubles;
  std::vector<std::array<float, 512>> floats;
};

/// The result for one cube of blocks.
struct Found {
  std::vector<Block> blocks;  // without values
  Samples samples;            // of each block, unless only masks are wanted
  std::vector<InsideTile> tiles;
};

class SampledFrames : public FrameSource {
 public:
  SampledFrames(FieldFunction field, const Lattice& lattice, const model::Bounds3& box,
                std::vector<double> times, const SampleOptions& options)
      : field_(std::move(field)), lattice_(lattice), times_(std::move(times)), options_(options) {
    if (!(options_.band > 0)) options_.band = 3 * lattice.voxelSize;
    for (int axis = 0; axis < 3; ++axis) {
      const auto index = [&](double x) { return (x - lattice.origin[axis]) / lattice.voxelSize; };
      const double first = std::ceil(index(box.min[axis]));
      const double last = std::floor(index(box.max[axis]));
      isNear_ = isNear_ && first >= -kMaxCoordinate && last <= kMaxCoordinate;
      if (!isNear_) break;
      first_[axis] = static_cast<std::int32_t>(first);
      last_[axis] = static_cast<std::int32_t>(last);
    }
  }

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return times_.size(); }

  Result<Frame> frame(std::size_t index) override {
    if (!isNear_) {
      return invalid(
          fmt::format("the box of the field is more than {} voxels from the lattice's "
                      "origin",
                      kMaxCoordinate));
    }
    const double time = times_[index];
    std::vector<Coord> cubes;
    constexpr std::int32_t kPoints = kBlockSize * kLargestCube;
    const auto cubeOf = [](std::int32_t point) { return point >> 7; };
    static_assert(kPoints == 128);
    for (std::int32_t x = cubeOf(first_[0]); x <= cubeOf(last_[0]); ++x) {
      for (std::int32_t y = cubeOf(first_[1]); y <= cubeOf(last_[1]); ++y) {
        for (std::int32_t z = cubeOf(first_[2]); z <= cubeOf(last_[2]); ++z) {
          cubes.push_back({x * kLargestCube, y * kLargestCube, z * kLargestCube});
        }
      }
    }
    std::vector<Found> found(cubes.size());
    model::forEach(cubes.size(), [&](std::size_t i) {
      sample(cubes[i], kLargestCube, time, found[i]);
      found[i].samples.doubles.shrink_to_fit();
      found[i].samples.floats.shrink_to_fit();
    });
    return gather(std::move(found), time);
  }

 private:
  bool outsideBox(const Coord& coord, std::int32_t size) const {
    const std::array<std::int32_t, 3> block = {coord.x, coord.y, coord.z};
    for (int axis = 0; axis < 3; ++axis) {
      if (block[axis] * kBlockSize > last_[axis]) return true;
      if ((block[axis] + size) * kBlockSize <= first_[axis]) return true;
    }
    return false;
  }
  bool withinBox(const Coord& coord, std::int32_t size) const {
    const std::array<std::int32_t, 3> block = {coord.x, coord.y, coord.z};
    for (int axis = 0; axis < 3; ++axis) {
      if (block[axis] * kBlockSize < first_[axis]) return false;
      if ((block[axis] + size) * kBlockSize - 1 > last_[axis]) return false;
    }
    return true;
  }

  void sample(const Coord& coord, std::int32_t size, double time, Found& found) const {
    if (outsideBox(coord, size)) return;
    if (options_.slope > 0 && withinBox(coord, size)) {
      const double half = 0.5 * (size * kBlockSize - 1);
      const Eigen::Vector3d centre =
          kBlockSize * Eigen::Vector3d(coord.x, coord.y, coord.z) + Eigen::Vector3d::Constant(half);
      const double value = field_(lattice_(centre), time);
      const double radius = std::sqrt(3.0) * half * lattice_.voxelSize;
      if (std::abs(value) > options_.slope * radius + options_.band) {
        if (value < 0) found.tiles.push_back({coord, size, tileValue()});
        return;
      }
    }
    if (size == 1) return sampleBlock(coord, time, found);
    const std::int32_t half = size / 2;
    for (std::int32_t i = 0; i < 8; ++i) {
      sample({coord.x + half * (i & 1), coord.y + half * (i >> 1 & 1), coord.z + half * (i >> 2)},
             half, time, found);
    }
  }

  double tileValue() const { return options_.mask ? 0 : -options_.band; }

  void sampleBlock(const Coord& coord, double time, Found& found) const {
    Block block{coord, {}, {}};
    std::array<double, 512> values{};
    bool near = false;
    bool anyInside = false;
    bool anyOutside = false;
    for (std::int32_t i = 0; i < 512; ++i) {
      const Eigen::Vector3i point(kBlockSize * coord.x + i / 64, kBlockSize * coord.y + i / 8 % 8,
                                  kBlockSize * coord.z + i % 8);
      bool within = true;
      for (int axis = 0; axis < 3; ++axis) {
        within = within && point[axis] >= first_[axis] && point[axis] <= last_[axis];
      }
      double value = within ? field_(lattice_(point.cast<double>()), time) : options_.band;
      if (options_.asFloat) value = static_cast<double>(static_cast<float>(value));
      values[i] = value;
      near = near || std::abs(value) < options_.band;
      anyOutside = anyOutside || !(value < 0);
      if (value < 0) {
        anyInside = true;
        block.inside[i / 64] |= std::uint64_t{1} << (i % 64);
      }
    }
    if (anyInside && !anyOutside && (options_.mask || !near)) {
      found.tiles.push_back({coord, 1, tileValue()});
    } else if (options_.mask ? anyInside : near || anyInside) {
      found.blocks.push_back(block);
      if (options_.mask) return;
      if (options_.asFloat) {
        std::ranges::transform(values, found.samples.floats.emplace_back().begin(),
                               [](double value) { return static_cast<float>(value); });
      } else {
        found.samples.doubles.push_back(values);
      }
    }
  }

  Frame gather(std::vector<Found> found, double time) const {
    Frame frame;
    frame.time = time;
    const auto samples = std::make_shared<std::vector<Samples>>();
    for (Found& part : found) {
      frame.tiles.insert(frame.tiles.end(), part.tiles.begin(), part.tiles.end());
      const Samples& values = samples->emplace_back(std::move(part.samples));
      for (std::size_t i = 0; i < part.blocks.size(); ++i) {
        Block& block = frame.blocks.emplace_back(part.blocks[i]);
        if (!values.floats.empty()) block.values.floats = values.floats[i].data();
        if (!values.doubles.empty()) block.values.doubles = values.doubles[i].data();
      }
    }
    if (!options_.mask) {
      frame.outsideValue = options_.band;
      frame.owner = samples;
    }
    const auto byCoord = [](const auto& a, const auto& b) { return a.coord < b.coord; };
    std::sort(frame.blocks.begin(), frame.blocks.end(), byCoord);
    std::sort(frame.tiles.begin(), frame.tiles.end(), byCoord);
    return frame;
  }

  FieldFunction field_;
  Lattice lattice_;
  std::array<std::int32_t, 3> first_{};  // lattice points of the box
  std::array<std::int32_t, 3> last_{};
  bool isNear_ = true;  // near enough for 32-bit coordinates
  std::vector<double> times_;
  SampleOptions options_;
};

}  // namespace

std::unique_ptr<FrameSource> sampledFrames(FieldFunction field, const Lattice& lattice,
                                           const model::Bounds3& box, std::vector<double> times,
                                           const SampleOptions& options) {
  return std::make_unique<SampledFrames>(std::move(field), lattice, box, std::move(times), options);
}

}  // namespace t4d::voxel4d
