#include "voxel4d/sampled_frames.h"

#include <bit>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "fixtures/fields.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;

/// The value of a frame at a point: the field where it is stored, else plus or minus the band.
double valueAt(const Frame& frame, int x, int y, int z) {
  const Coord coord{x >> 3, y >> 3, z >> 3};
  for (const Block& block : frame.blocks) {
    if (block.coord == coord) {
      return block.values.at(static_cast<unsigned>(64 * (x & 7) + 8 * (y & 7) + (z & 7)));
    }
  }
  for (const InsideTile& tile : frame.tiles) {
    const auto within = [&](int c, int from) { return c >= from && c < from + tile.size; };
    if (within(coord.x, tile.coord.x) && within(coord.y, tile.coord.y) &&
        within(coord.z, tile.coord.z)) {
      return tile.value;
    }
  }
  return frame.outsideValue;
}

TEST(SampledFrames, TakeTheBandThatIsGiven) {
  const auto field = fixtures::translatingSphere(40, {3, 0, 0});
  for (const double band : {0.5, 1.0, 7.0}) {
    const auto frames = sampledFrames(field.value, {}, field.box, {0, 1}, {.band = band});
    const auto frame = frames->frame(0);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->outsideValue, band);
  }
  const auto usual = sampledFrames(field.value, {0.25, {0, 0, 0}}, field.box, {0, 1})->frame(0);
  ASSERT_TRUE(usual);
  EXPECT_EQ(usual->outsideValue, 0.75);
}

TEST(SampledFrames, HoldTheFieldNearTheSurfaceAndItsSignElsewhere) {
  const auto field = fixtures::translatingSphere(40, {3, 0, 0});
  for (const double slope : {0.0, 1.0}) {
    SampleOptions options;
    options.slope = slope;
    const auto frames = sampledFrames(field.value, {}, field.box, {0, 1}, options);
    ASSERT_EQ(frames->frameCount(), 2U);
    const auto frame = frames->frame(1);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time, 1);
    EXPECT_EQ(frame->outsideValue, 3);
    for (int x = -48; x <= 48; x += 3) {
      for (int y = -48; y <= 48; y += 5) {
        const double expected = field.value(Point3(x, y, 1), 1);
        const double found = valueAt(*frame, x, y, 1);
        if (std::abs(expected) < 3) {
          EXPECT_EQ(found, expected);
        } else {
          EXPECT_EQ(found < 0, expected < 0) << x << " " << y;
        }
      }
    }
    for (std::size_t i = 1; i < frame->blocks.size(); ++i) {
      EXPECT_LT(frame->blocks[i - 1].coord, frame->blocks[i].coord);
    }
  }
}

TEST(SampledFrames, LargeCubesInsideAreOneTile) {
  const auto field = fixtures::translatingSphere(300, {0, 0, 0});
  SampleOptions options;
  options.slope = 1;
  options.asFloat = true;
  const auto frame = sampledFrames(field.value, {}, field.box, {0, 1}, options)->frame(0);
  ASSERT_TRUE(frame);
  std::map<int, int> sizes;
  for (const InsideTile& tile : frame->tiles) ++sizes[tile.size];
  EXPECT_GT(sizes[16], 0);
  EXPECT_GT(sizes[1], 0);
  EXPECT_LT(frame->blocks.size(), 60'000U);
}

TEST(SampledFrames, MasksHaveNoValues) {
  const auto field = fixtures::checkerboard(9);
  SampleOptions options;
  options.mask = true;
  const auto frames = sampledFrames(field.value, {}, field.box, {0, 1}, options);
  const auto frame = frames->frame(0);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->hasValues());
  int inside = 0;
  for (const Block& block : frame->blocks) {
    EXPECT_TRUE(block.values.empty());
    for (const std::uint64_t word : block.inside) inside += std::popcount(word);
  }
  EXPECT_EQ(inside, (9 * 9 * 9 + 1) / 2);
}

TEST(SampledFrames, NothingOutsideTheBoxIsInside) {
  const auto frame = sampledFrames([](const Point3&, double) { return -1.0; }, {},
                                   {Point3(-3, -3, -3), Point3(3, 3, 3)}, {0, 1}, {})
                         ->frame(0);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->blocks.size(), 8U);
  EXPECT_LT(valueAt(*frame, 3, -3, 0), 0);
  EXPECT_GT(valueAt(*frame, 4, 0, 0), 0);
}

}  // namespace
}  // namespace t4d::voxel4d
