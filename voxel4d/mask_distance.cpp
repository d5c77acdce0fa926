#include "voxel4d/mask_distance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace t4d::voxel4d {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();

/// Lowers each of the 64 points (y, z) to the other, so far away, if that is nearer.
void takeNearer(float* nearest, const float* other, float away) {
  for (int i = 0; i < 64; ++i) {
    const float square = other[i] + away;
    nearest[i] = square < nearest[i] ? square : nearest[i];
  }
}

}  // namespace

FaceMetric::FaceMetric(const std::array<double, 3>& edges) {
  const double shortest = std::ranges::min(edges);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t voxels = 1; voxels <= kReach; ++voxels) {
      const double distance = (static_cast<double>(voxels) - 0.5) * edges[axis] / shortest;
      squares_[axis][voxels] = static_cast<float>(distance * distance);
    }
  }
}

/// A block and `kBlocks` beside it along x and y; along z, 3 below and 4 above.
template <std::int32_t kBlocks>
class FaceDistance::Neighbourhood {
 public:
  /// All faces that are nearer than this, in shortest edges, are found.
  static constexpr float kFound = static_cast<float>(kBlocks * kBlockSize) + 0.5F;

  Neighbourhood(const FrameLayer& frame, const Coord& block) {
    for (std::int32_t x = -kBlocks; x <= kBlocks; ++x) {
      for (std::int32_t y = -kBlocks; y <= kBlocks; ++y) {
        std::uint64_t* const first = &columns_[indexOf((x + kBlocks) * kBlockSize,  //
                                                       (y + kBlocks) * kBlockSize)];
        for (std::int32_t z = 0; z < kBlockSize; ++z) {
          const BlockView view = frame.view({block.x + x, block.y + y, block.z + z - kBelow});
          if (view.block == nullptr && !view.inside) continue;
          for (std::int32_t i = 0; i < kBlockSize; ++i) {
            const std::uint64_t word = view.word(static_cast<unsigned>(i));
            for (std::int32_t k = 0; k < kBlockSize; ++k) {
              first[i * kSize + k] |= (word >> (8 * k) & 0xFFU) << (8 * z);
            }
          }
        }
      }
    }
  }

  /// The squares of distances from voxels inside, or outside.
  std::unique_ptr<Squares> squaresFrom(bool inside, const FaceMetric& metric) const {
    auto nearest = std::make_unique<Squares>();
    nearest->fill(kInfinite);
    std::array<float, std::size_t{kSize} * kBlockSize> alongZ;  // of the points (y, z) of one x
    std::array<float, 64> alongY;
    const auto& [byX, byY, byZ] = metric.squares_;
    for (std::int32_t x = 0; x < kSize; ++x) {
      bool any = false;
      for (std::int32_t y = 0; y < kSize; ++y) {
        const std::uint64_t word = columns_[indexOf(x, y)];
        const std::uint64_t others = inside ? word : ~word;
        any = any || others != 0;
        for (std::int32_t z = 0; z < kBlockSize; ++z) {
          const int at = kBelow * kBlockSize + z;
          const int away =
              std::min(std::countr_zero(others >> at), std::countl_zero(others << (63 - at)));
          alongZ[static_cast<std::size_t>(y * kBlockSize + z)] =
              away <= FaceMetric::kReach ? byZ[static_cast<std::size_t>(away)] : kInfinite;
        }
      }
      if (!any) continue;
      alongY.fill(kInfinite);
      for (std::int32_t y = -kAround; y <= kAround; ++y) {
        takeNearer(alongY.data(), &alongZ[static_cast<std::size_t>((y + kAround) * kBlockSize)],
                   byY[static_cast<std::size_t>(std::abs(y))]);
      }
      for (std::int32_t to = 0; to < kBlockSize; ++to) {
        const std::int32_t away = std::abs(x - kAround - to);
        if (away > kAround) continue;
        takeNearer(&(*nearest)[static_cast<std::size_t>(to * 64)], alongY.data(),
                   byX[static_cast<std::size_t>(away)]);
      }
    }
    return nearest;
  }

 private:
  static constexpr std::int32_t kAround = kBlocks * kBlockSize;  // voxels beside the block
  static constexpr std::int32_t kSize = 2 * kAround + kBlockSize;
  static constexpr std::int32_t kBelow = FaceMetric::kReach / kBlockSize;  // blocks
  static std::size_t indexOf(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(x * kSize + y);
  }

  // A bit for each voxel along z.
  std::vector<std::uint64_t> columns_ = std::vector<std::uint64_t>(std::size_t{kSize} * kSize);
};

double FaceDistance::at(unsigned index) {
  const bool inside = (own_.word(index >> 6U) >> (index & 63U) & 1U) != 0;
  using Next = Neighbourhood<1>;
  using All = Neighbourhood<FaceMetric::kReach / kBlockSize>;
  const auto look = [&]<class Where>(std::unique_ptr<Squares>& squares) {
    if (!squares) squares = Where(frame_, block_).squaresFrom(!inside, metric_);
    return std::min(std::sqrt((*squares)[index]), Where::kFound);
  };
  const std::size_t side = inside ? 1 : 0;
  float distance = look.template operator()<Next>(near_[side]);
  if (distance == Next::kFound) distance = look.template operator()<All>(far_[side]);
  return inside ? -distance : distance;
}

}  // namespace t4d::voxel4d
