#include "mill/stock_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "measure/visit_lattice.h"
#include "model/parallel.h"
#include "model/voxel_size.h"
#include "t4d/mesh.h"

namespace t4d::mill {
namespace {

using Index3 = std::array<std::int32_t, 3>;

constexpr std::int32_t kSize = voxel4d::kBlockSize;

// Voxel coordinates are 32-bit numbers, and a frame has 8 of them a block.
constexpr double kMostIndex = 1 << 30;

/// The multiples of the voxel size about the bounds, with one more on each side.
struct Part {
  Index3 first{};
  measure::SpaceLattice lattice;
};

Result<Part> partAbout(const model::Bounds3& bounds, double voxelSize) {
  if (auto sized = model::checkVoxelSize(voxelSize); !sized) return sized.error();
  Part part;
  part.lattice.spacing = voxelSize;
  for (int axis = 0; axis < 3; ++axis) {
    const double least = std::floor(bounds.min[axis] / voxelSize) - 1;
    const double most = std::ceil(bounds.max[axis] / voxelSize) + 1;
    if (!(std::abs(least) < kMostIndex) || !(std::abs(most) < kMostIndex) ||
        !(most - least < measure::SpaceLattice::kMostPoints - 1)) {
      return model::tooManyVoxels(voxelSize, most - least, measure::SpaceLattice::kMostPoints,
                                  fmt::format(", up to {:.3g} away from the origin", kMostIndex));
    }
    part.first[axis] = static_cast<std::int32_t>(least);
    for (double i = least; i <= most; ++i) part.lattice.at[axis].push_back(i * voxelSize);
  }
  return part;
}

std::int32_t blockOf(std::int32_t point) { return point >> 3; }

/// A voxel size at which `bytes` become `memory`, rounded up to two digits. Most of the bytes go
/// with its square.
double fitting(double voxelSize, double bytes, double memory) {
  const double size = voxelSize * std::sqrt(bytes / memory);
  const double digit = std::pow(10, std::floor(std::log10(size)) - 1);
  return std::ceil(size / digit) * digit;
}

}  // namespace

/// A closed surface as a field: negative inside, in blocks that it crosses; the others are inside
/// or outside as a whole.
class StockField::Sampled {
 public:
  static Result<Sampled> of(const model::TriangleMesh& surface, double voxelSize) {
    auto part = partAbout(model::boundsOf(surface), voxelSize);
    if (!part) return part.error();
    return Sampled(surface, std::move(*part), voxelSize);
  }

  struct SampledBlock {
    Index3 block{};
    std::array<float, 512> values{};
  };
  std::vector<SampledBlock> blocks;
  std::vector<Index3> inside;  // blocks

 private:
  Sampled(const model::TriangleMesh& surface, Part part, double voxelSize) {
    const Index3 first = part.first;
    const measure::VisitLattice visits(surface, std::move(part.lattice));
    const auto& at = visits.lattice().at;
    Index3 firstBlock{};
    Index3 counts{};
    for (int axis = 0; axis < 3; ++axis) {
      firstBlock[axis] = blockOf(first[axis]);
      const auto last = static_cast<std::int32_t>(first[axis] + at[axis].size() - 1);
      counts[axis] = blockOf(last) - firstBlock[axis] + 1;
    }
    const auto count = std::size_t{1} * counts[0] * counts[1] * counts[2];
    std::vector<std::uint32_t> numbers(count, model::kNoIndex);
    const auto add = [&](const Index3& point, float distance) {
      Index3 block{};
      for (int axis = 0; axis < 3; ++axis) block[axis] = blockOf(point[axis]);
      std::uint32_t& number = numbers[(std::size_t{1} * (block[0] - firstBlock[0]) * counts[1] +
                                       block[1] - firstBlock[1]) *
                                          counts[2] +
                                      block[2] - firstBlock[2]];
      if (number == model::kNoIndex) {
        number = static_cast<std::uint32_t>(blocks.size());
        blocks.push_back({block, {}});
        blocks.back().values.fill(static_cast<float>(voxelSize));
      }
      float& value =
          blocks[number].values[(point[0] & 7) << 6 | (point[1] & 7) << 3 | (point[2] & 7)];
      value = std::min(value, distance);
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (const measure::LatticeCrossing& crossing : visits.crossings(axis)) {
        const measure::LatticeIndex low = measure::indexOf(crossing.key);
        const double across = std::abs(crossing.normal[axis]) * voxelSize;
        Index3 point{};
        for (int i = 0; i < 3; ++i) point[i] = first[i] + static_cast<std::int32_t>(low[i]);
        add(point, static_cast<float>(crossing.fraction * across));
        ++point[axis];
        add(point, static_cast<float>((1 - crossing.fraction) * across));
      }
    }
    const auto isInside = [&](const Index3& point) {
      measure::LatticeIndex index{};
      for (int axis = 0; axis < 3; ++axis) {
        const std::int32_t offset = point[axis] - first[axis];
        if (offset < 0 || offset >= static_cast<std::int32_t>(at[axis].size())) return false;
        index[axis] = static_cast<std::uint32_t>(offset);
      }
      return visits.isInside(index);
    };
    model::forEach(blocks.size(), [&](std::size_t b) {
      auto& [block, values] = blocks[b];
      for (std::int32_t i = 0; i < 512; ++i) {
        const Index3 point = {kSize * block[0] + (i >> 6), kSize * block[1] + (i >> 3 & 7),
                              kSize * block[2] + (i & 7)};
        if (isInside(point)) values[i] = -values[i];
      }
    });
    for (std::int32_t x = 0; x < counts[0]; ++x) {
      for (std::int32_t y = 0; y < counts[1]; ++y) {
        for (std::int32_t z = 0; z < counts[2]; ++z) {
          if (numbers[(std::size_t{1} * x * counts[1] + y) * counts[2] + z] != model::kNoIndex)
            continue;
          const Index3 block = {firstBlock[0] + x, firstBlock[1] + y, firstBlock[2] + z};
          if (isInside({kSize * block[0], kSize * block[1], kSize * block[2]})) {
            inside.push_back(block);
          }
        }
      }
    }
  }
};

Result<StockField> StockField::sized(const model::TriangleMesh& solid, double voxelSize,
                                     double memory) {
  const auto part = partAbout(model::boundsOf(solid), voxelSize);
  if (!part) return part.error();
  StockField field;
  field.voxelSize_ = voxelSize;
  double blocks = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto last =
        static_cast<std::int32_t>(part->first[axis] + part->lattice.at[axis].size() - 1);
    field.first_[axis] = blockOf(part->first[axis]);
    field.counts_[axis] = blockOf(last) - field.first_[axis] + 1;
    blocks *= field.counts_[axis];
  }
  const double bytes = measure::VisitLattice::estimatedBytes(solid, part->lattice) +
                       blocks * (sizeof(field.blocks_[0]) + sizeof(Uniform));
  if (bytes > memory) {
    return model::tooMuchMemory({voxelSize, bytes, memory}, "the stock needs",
                                fmt::format("{:g} fits", fitting(voxelSize, bytes, memory)));
  }
  return field;
}

Result<StockField> StockField::of(const model::TriangleMesh& solid, double voxelSize,
                                  double memory) {
  auto field = sized(solid, voxelSize, memory);
  if (!field) return field;
  const auto sampled = Sampled::of(solid, voxelSize);
  if (!sampled) return sampled.error();
  field->blocks_.resize(static_cast<std::size_t>(field->counts_[0]) *
                        static_cast<std::size_t>(field->counts_[1]) *
                        static_cast<std::size_t>(field->counts_[2]));
  field->uniform_.assign(field->blocks_.size(), Uniform::Outside);
  for (const auto& [block, values] : sampled->blocks) {
    auto data = std::make_shared<BlockData>();
    data->values = values;
    for (std::size_t i = 0; i < 512; ++i) {
      if (values[i] < 0) data->inside[i >> 6U] |= std::uint64_t{1} << (i & 63U);
    }
    field->blocks_[field->indexOf(block)] = std::move(data);
  }
  for (const Index3& block : sampled->inside)
    field->uniform_[field->indexOf(block)] = Uniform::Inside;
  return field;
}

Result<void> StockField::checkSize(const model::TriangleMesh& solid, double voxelSize,
                                   double memory) {
  model::Bounds3 bounds = model::boundsOf(solid);
  const model::Point3 size = bounds.max - bounds.min;
  bounds.min.setZero();
  bounds.max = size;
  const auto part = partAbout(bounds, voxelSize);
  double blocks = 1;
  for (int axis = 0; axis < 3; ++axis) blocks *= std::ceil(size[axis] / (kSize * voxelSize)) + 1;
  if (part && measure::VisitLattice::estimatedBytes(solid, part->lattice) + 4 * blocks <= memory) {
    return {};
  }
  return fail(ErrorCode::Unsupported,
              fmt::format("is {:g} x {:g} x {:g} large, too large for voxels of {:g}; is it in the "
                          "length units of the stock?",
                          size.x(), size.y(), size.z(), voxelSize));
}

bool StockField::empty() const {
  const auto isInside = [](const auto& data) {
    return data != nullptr &&
           std::ranges::any_of(data->inside, [](auto bits) { return bits != 0; });
  };
  return std::ranges::find(uniform_, Uniform::Inside) == uniform_.end() &&
         std::ranges::none_of(blocks_, isInside);
}

std::size_t StockField::indexOf(const Index3& block) const {
  return (std::size_t{1} * (block[0] - first_[0]) * counts_[1] + (block[1] - first_[1])) *
             counts_[2] +
         (block[2] - first_[2]);
}

bool StockField::mayMeet(const model::Bounds3& bounds) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double begin = voxelSize_ * kSize * first_[axis];
    const double end = begin + voxelSize_ * kSize * counts_[axis];
    if (bounds.max[axis] < begin - voxelSize_ || bounds.min[axis] > end) return false;
  }
  return true;
}

namespace {

/// Keeps the point with the least value.
class Deepest {
 public:
  void add(const Index3& block, std::int32_t i, float value) {
    ++count_;
    if (count_ > 1 && !(value < value_)) return;
    value_ = value;
    point_ = {kSize * block[0] + (i >> 6), kSize * block[1] + (i >> 3 & 7),
              kSize * block[2] + (i & 7)};
  }
  StockField::Place at(double voxelSize) const {
    return {voxelSize * model::Point3(point_[0], point_[1], point_[2]), count_, false};
  }

 private:
  Index3 point_{};
  float value_ = 0;
  std::uint64_t count_ = 0;
};

bool within(const Index3& block, const Index3& first, const Index3& counts) {
  for (int axis = 0; axis < 3; ++axis) {
    if (block[axis] < first[axis] || block[axis] >= first[axis] + counts[axis]) return false;
  }
  return true;
}

}  // namespace

Result<StockField::Place> StockField::remove(const model::TriangleMesh& surface) {
  if (!mayMeet(model::boundsOf(surface))) return Place{};
  const auto tool = Sampled::of(surface, voxelSize_);
  if (!tool) return tool.error();
  Deepest removed;
  bool changesAny = false;
  for (const auto& [block, values] : tool->blocks) {
    if (!within(block, first_, counts_)) continue;
    const std::size_t index = indexOf(block);
    const BlockData* before = blocks_[index].get();
    if (before == nullptr && uniform_[index] == Uniform::Outside) continue;
    const auto valueBefore = [&](std::size_t i) {
      return before != nullptr ? before->values[i] : -band();
    };
    bool changes = false;
    for (std::size_t i = 0; i < 512; ++i) changes = changes || -values[i] > valueBefore(i);
    if (!changes) continue;
    changesAny = true;
    auto data = std::make_shared<BlockData>();
    bool empty = true;
    for (std::size_t i = 0; i < 512; ++i) {
      const float old = valueBefore(i);
      const float now = std::max(old, -values[i]);
      data->values[i] = now;
      empty = empty && now >= band();
      if (now < 0) {
        data->inside[i >> 6U] |= std::uint64_t{1} << (i & 63U);
      } else if (old < 0) {
        removed.add(block, static_cast<std::int32_t>(i), old);
      }
    }
    uniform_[index] = Uniform::Outside;
    blocks_[index] = empty ? nullptr : std::move(data);
  }
  for (const Index3& block : tool->inside) {
    if (!within(block, first_, counts_)) continue;
    const std::size_t index = indexOf(block);
    const BlockData* before = blocks_[index].get();
    if (before == nullptr && uniform_[index] == Uniform::Outside) continue;
    for (std::int32_t i = 0; i < 512; ++i) {
      const float old = before != nullptr ? before->values[i] : -band();
      if (old < 0) removed.add(block, i, old);
    }
    changesAny = true;
    uniform_[index] = Uniform::Outside;
    blocks_[index] = nullptr;
  }
  Place found = removed.at(voxelSize_);
  found.changes = changesAny;
  return found;
}

Result<StockField::Place> StockField::meet(const model::TriangleMesh& surface) const {
  if (!mayMeet(model::boundsOf(surface))) return Place{};
  const auto other = Sampled::of(surface, voxelSize_);
  if (!other) return other.error();
  Deepest met;
  const auto look = [&](const Index3& block, const float* values) {
    if (!within(block, first_, counts_)) return;
    const std::size_t index = indexOf(block);
    const BlockData* own = blocks_[index].get();
    if (own == nullptr && uniform_[index] == Uniform::Outside) return;
    for (std::int32_t i = 0; i < 512; ++i) {
      const float value = own != nullptr ? own->values[i] : -band();
      if (value < 0 && (values == nullptr || values[i] < 0)) met.add(block, i, value);
    }
  };
  for (const auto& [block, values] : other->blocks) look(block, values.data());
  for (const Index3& block : other->inside) look(block, nullptr);
  return met.at(voxelSize_);
}

bool StockField::gatherTiles(const Index3& at, std::int32_t size,
                             std::vector<voxel4d::InsideTile>& tiles) const {
  if (size == 1) {
    if (!within(at, first_, counts_)) return false;
    const std::size_t index = indexOf(at);
    return blocks_[index] == nullptr && uniform_[index] == Uniform::Inside;
  }
  const std::int32_t half = size / 2;
  std::array<bool, 8> full{};
  const auto child = [&](std::int32_t i) {
    return Index3{at[0] + half * (i >> 2), at[1] + half * (i >> 1 & 1), at[2] + half * (i & 1)};
  };
  for (std::int32_t i = 0; i < 8; ++i) {
    const Index3 begin = child(i);
    bool meets = true;
    for (int axis = 0; axis < 3; ++axis) {
      meets =
          meets && begin[axis] < first_[axis] + counts_[axis] && begin[axis] + half > first_[axis];
    }
    full[i] = meets && gatherTiles(begin, half, tiles);
  }
  if (std::ranges::all_of(full, [](bool one) { return one; })) return true;
  for (std::int32_t i = 0; i < 8; ++i) {
    if (!full[i]) continue;
    const Index3 begin = child(i);
    tiles.push_back({{begin[0], begin[1], begin[2]}, half, -static_cast<double>(band())});
  }
  return false;
}

voxel4d::Frame StockField::frame(double time) const {
  voxel4d::Frame frame;
  frame.time = time;
  frame.outsideValue = band();
  auto owner = std::make_shared<std::vector<std::shared_ptr<const BlockData>>>();
  for (std::size_t index = 0; index < blocks_.size(); ++index) {
    const auto& data = blocks_[index];
    if (!data) continue;
    const auto yz = static_cast<std::int32_t>(index % (std::size_t{1} * counts_[1] * counts_[2]));
    voxel4d::Block block;
    block.coord = {
        first_[0] + static_cast<std::int32_t>(index / (std::size_t{1} * counts_[1] * counts_[2])),
        first_[1] + yz / counts_[2], first_[2] + yz % counts_[2]};
    block.inside = data->inside;
    block.values.floats = data->values.data();
    frame.blocks.push_back(block);
    owner->push_back(data);
  }
  constexpr std::int32_t kLargestTile = 64;
  const auto cubeOf = [](std::int32_t block) { return block >> 6; };
  const auto last = [&](int axis) { return first_[axis] + counts_[axis] - 1; };
  for (std::int32_t x = cubeOf(first_[0]); x <= cubeOf(last(0)); ++x) {
    for (std::int32_t y = cubeOf(first_[1]); y <= cubeOf(last(1)); ++y) {
      for (std::int32_t z = cubeOf(first_[2]); z <= cubeOf(last(2)); ++z) {
        const Index3 cube = {kLargestTile * x, kLargestTile * y, kLargestTile * z};
        if (gatherTiles(cube, kLargestTile, frame.tiles)) {
          frame.tiles.push_back(
              {{cube[0], cube[1], cube[2]}, kLargestTile, -static_cast<double>(band())});
        }
      }
    }
  }
  std::ranges::sort(frame.tiles, {}, &voxel4d::InsideTile::coord);
  frame.owner = std::move(owner);
  return frame;
}

std::array<std::int32_t, 3> StockField::pointCounts() const {
  return {kSize * counts_[0], kSize * counts_[1], kSize * counts_[2]};
}

void StockField::runsOf(std::int32_t x, std::int32_t y, std::vector<Run>& runs) const {
  runs.clear();
  const std::size_t line = (std::size_t{1} * blockOf(x) * counts_[1] + blockOf(y)) * counts_[2];
  for (std::int32_t block = 0; block < counts_[2]; ++block) {
    const BlockData* data = blocks_[line + block].get();
    std::uint32_t bits = uniform_[line + block] == Uniform::Inside ? 0xFFU : 0;
    if (data != nullptr) {
      bits = static_cast<std::uint32_t>(data->inside[x & 7] >> (8 * (y & 7)) & 0xFFU);
    }
    std::int32_t z = kSize * block;
    while (bits != 0) {
      const int zeros = std::countr_zero(bits);
      bits >>= zeros;
      const int ones = std::countr_one(bits);
      bits >>= ones;
      const std::int32_t begin = z + zeros;
      if (!runs.empty() && runs.back().end == begin) {
        runs.back().end = begin + ones;
      } else {
        runs.push_back({begin, begin + ones});
      }
      z = begin + ones;
    }
  }
}

}  // namespace t4d::mill
