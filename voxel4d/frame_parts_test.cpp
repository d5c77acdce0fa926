#include "voxel4d/frame_parts.h"

#include <memory>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "t4d/frames.h"
#include "t4d/mesh.h"
#include "t4d/weave.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;

/// Samples of a box of lattice points from (0, 0, 0) on.
class Box {
 public:
  explicit Box(std::array<std::size_t, 3> size)
      : size_(size),
        count_(size[0] * size[1] * size[2]),
        inside_(std::make_unique<bool[]>(count_)) {}

  std::span<const bool> samples() const { return {inside_.get(), count_}; }
  const std::array<std::size_t, 3>& size() const { return size_; }
  bool& operator()(std::size_t x, std::size_t y, std::size_t z) {
    return inside_[(x * size_[1] + y) * size_[2] + z];
  }
  void fill(const std::array<std::size_t, 3>& from, const std::array<std::size_t, 3>& to) {
    for (std::size_t x = from[0]; x < to[0]; ++x) {
      for (std::size_t y = from[1]; y < to[1]; ++y) {
        for (std::size_t z = from[2]; z < to[2]; ++z) (*this)(x, y, z) = true;
      }
    }
  }

  /// The number of parts, by looking at one point after the other.
  std::size_t countParts() {
    std::set<std::array<std::size_t, 3>> left;
    for (std::size_t x = 0; x < size_[0]; ++x) {
      for (std::size_t y = 0; y < size_[1]; ++y) {
        for (std::size_t z = 0; z < size_[2]; ++z) {
          if ((*this)(x, y, z)) left.insert({x, y, z});
        }
      }
    }
    std::size_t parts = 0;
    for (; !left.empty(); ++parts) {
      std::vector<std::array<std::size_t, 3>> next = {*left.begin()};
      left.erase(left.begin());
      while (!next.empty()) {
        const auto at = next.back();
        next.pop_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (const std::size_t by : {std::size_t{1}, ~std::size_t{0}}) {
            auto beside = at;
            beside[axis] += by;
            if (left.erase(beside) > 0) next.push_back(beside);
          }
        }
      }
    }
    return parts;
  }

 private:
  std::array<std::size_t, 3> size_;
  std::size_t count_;
  std::unique_ptr<bool[]> inside_;
};

std::unique_ptr<FrameSource> framesOf(const std::vector<Box>& boxes) {
  std::vector<ArrayFrame<bool>> frames;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    frames.push_back({10 + static_cast<double>(i), boxes[i].samples()});
  }
  auto source = arrayFrames<bool>(frames, {.size = boxes.front().size()});
  EXPECT_TRUE(source);
  return source ? std::move(*source) : nullptr;
}

TEST(FrameParts, AreAsManyAsAFloodFinds) {
  std::mt19937 random(5);
  for (const double density : {0.02, 0.06, 0.4, 0.5, 0.9, 0.999}) {
    SCOPED_TRACE(density);
    std::vector<Box> boxes;
    boxes.emplace_back(std::array<std::size_t, 3>{19, 33, 26});
    boxes.emplace_back(std::array<std::size_t, 3>{19, 33, 26});
    std::bernoulli_distribution toss(density);
    for (std::size_t x = 0; x < 19; ++x) {
      for (std::size_t y = 0; y < 33; ++y) {
        for (std::size_t z = 0; z < 26; ++z) boxes[0](x, y, z) = toss(random);
      }
    }
    // Some blocks that are all inside are tiles.
    boxes[0].fill({0, 8, 8}, {8, 24, 16});
    boxes[1] = Box({19, 33, 26});
    const auto source = framesOf(boxes);
    auto frame = source->frame(0);
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->tiles.empty());
    EXPECT_EQ(FrameParts(IndexedFrame(std::move(*frame))).count(), boxes[0].countParts());
  }
}

WeaveReport wovenReport(const std::vector<Box>& boxes, const WeaveOptions& options = {}) {
  model::NullSink nothing;
  const auto report = weave(*framesOf(boxes), options, nothing);
  EXPECT_TRUE(report);
  return report ? *report : WeaveReport{};
}

std::vector<Box> empty(std::size_t frames) {
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < frames; ++i)
    boxes.emplace_back(std::array<std::size_t, 3>{48, 48, 48});
  return boxes;
}

TEST(LostParts, APlateThatMovesByItsThicknessIsLostAndASlowerOneIsNot) {
  for (const std::size_t by : {2U, 3U, 5U}) {
    std::vector<Box> boxes = empty(3);
    for (std::size_t i = 0; i < 3; ++i) {
      boxes[i].fill({4 + by * i, 4, 4}, {7 + by * i, 40, 40});
      boxes[i].fill({40, 42, 42}, {46, 47, 47});  // something that stays
    }
    model::Affine3x4 toSpace = model::Affine3x4::Zero();
    toSpace.diagonal() << 2, 2, 2;
    toSpace.col(3) << 100, 0, 0;
    const WeaveReport report = wovenReport(boxes, {.toSpace = toSpace});
    if (by == 2) {
      EXPECT_EQ(report.partsLost.count, 0U);
      continue;
    }
    ASSERT_EQ(report.partsLost.count, 2U);
    ASSERT_EQ(report.partsLost.listed.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const LostPart& lost = report.partsLost.listed[i];
      EXPECT_EQ(lost.frame, i);
      EXPECT_EQ(lost.time, 10 + static_cast<double>(i));
      EXPECT_EQ(lost.voxels, 3U * 36 * 36);
      const double x = 5 + static_cast<double>(by * i);
      EXPECT_LT((lost.point - Point3(100 + 2 * x, 43, 43)).norm(), 1e-9);
    }
  }
}

TEST(LostParts, WhatEndsBeginsSplitsOrMeetsIsNotLost) {
  std::vector<Box> boxes = empty(4);
  boxes[0].fill({4, 4, 4}, {9, 9, 9});        // ends, and nothing begins near it
  boxes[1].fill({30, 30, 30}, {40, 40, 40});  // begins
  boxes[0].fill({12, 12, 12}, {24, 20, 20});  // splits
  boxes[1].fill({12, 12, 12}, {17, 20, 20});
  boxes[1].fill({19, 12, 12}, {24, 20, 20});
  boxes[2].fill({12, 12, 12}, {24, 20, 20});  // meets
  boxes[2].fill({30, 30, 30}, {40, 40, 40});
  boxes[3].fill({12, 12, 12}, {24, 20, 20});
  boxes[3].fill({43, 43, 43}, {45, 45, 45});  // of another size than what ends
  EXPECT_EQ(wovenReport(boxes).partsLost.count, 0U);
}

TEST(LostParts, TilesAreParts) {
  // Cubes of blocks that are all inside; the second lies beside the first.
  std::vector<Box> boxes = empty(2);
  boxes[0].fill({0, 0, 0}, {16, 16, 16});
  boxes[1].fill({16, 0, 0}, {32, 16, 16});
  ASSERT_EQ(wovenReport(boxes).partsLost.count, 1U);
  EXPECT_EQ(wovenReport(boxes).partsLost.listed[0].voxels, 4096U);
  EXPECT_EQ(wovenReport(boxes).partsLost.listed[0].point, Point3(7.5, 7.5, 7.5));
  boxes[1].fill({15, 3, 3}, {16, 4, 4});  // now they overlap in one point
  EXPECT_EQ(wovenReport(boxes).partsLost.count, 0U);
}

}  // namespace
}  // namespace t4d::voxel4d
