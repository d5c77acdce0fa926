#include "voxel4d/sample_box.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "voxel4d/frame_layer.h"

namespace t4d::voxel4d {
namespace {

/// Random samples in a box whose axes lie in memory in any order, with gaps between them.
template <class T>
struct Random {
  std::vector<std::byte> bytes;
  SampleBox box;

  Random(SampleType type, std::mt19937& random, auto sample) {
    box.type = type;
    std::array<std::size_t, 3> axes = {0, 1, 2};
    std::shuffle(axes.begin(), axes.end(), random);
    std::size_t stride = sizeof(T) * (random() % 3 == 0 ? 2 : 1);
    for (const std::size_t axis : axes) {
      box.size[axis] = 1 + random() % 21;
      box.strides[axis] = static_cast<std::ptrdiff_t>(stride);
      stride = stride * box.size[axis] + (random() % 3 == 0 ? sizeof(T) : 0);
    }
    bytes.resize(stride);
    box.first = bytes.data();
    for (const std::size_t axis : axes) {  // backwards along some axes
      if (random() % 4 != 0) continue;
      box.first += static_cast<std::ptrdiff_t>(box.size[axis] - 1) * box.strides[axis];
      box.strides[axis] = -box.strides[axis];
    }
    eachPoint([&](std::size_t x, std::size_t y, std::size_t z) {
      const T value = sample(x, y, z);
      std::memcpy(const_cast<std::byte*>(at(x, y, z)), &value, sizeof value);
    });
  }

  void eachPoint(auto visit) const {
    for (std::size_t x = 0; x < box.size[0]; ++x) {
      for (std::size_t y = 0; y < box.size[1]; ++y) {
        for (std::size_t z = 0; z < box.size[2]; ++z) visit(x, y, z);
      }
    }
  }
  const std::byte* at(std::size_t x, std::size_t y, std::size_t z) const {
    return box.first + static_cast<std::ptrdiff_t>(x) * box.strides[0] +
           static_cast<std::ptrdiff_t>(y) * box.strides[1] +
           static_cast<std::ptrdiff_t>(z) * box.strides[2];
  }
  T sample(std::size_t x, std::size_t y, std::size_t z) const {
    T value;
    std::memcpy(&value, at(x, y, z), sizeof value);
    return value;
  }
};

Coord blockOf(std::size_t x, std::size_t y, std::size_t z) {
  return {static_cast<std::int32_t>(x / 8), static_cast<std::int32_t>(y / 8),
          static_cast<std::int32_t>(z / 8)};
}

/// Whether a point is inside by the blocks and tiles.
bool isInside(const SampleSigns& signs, std::size_t x, std::size_t y, std::size_t z) {
  const Coord coord = blockOf(x, y, z);
  for (const Block& block : signs.blocks) {
    if (block.coord == coord) return (block.inside[x % 8] >> (8 * (y % 8) + z % 8) & 1U) != 0;
  }
  return std::ranges::any_of(signs.tiles,
                             [&](const InsideTile& tile) { return tile.coord == coord; });
}

/// Signs, usability, the farthest value and the field are those of the rule's definition, point by
/// point.
template <class T>
void expectDefinition(SampleType type, const SampleRule& rule, unsigned seed, auto sample) {
  std::mt19937 random(seed);
  const Random<T> given(type, random, [&](auto... at) { return sample(random, at...); });
  const SampleSigns signs = signsOf(given.box, rule);
  const auto field = [&](T value) {
    const auto number = static_cast<double>(value);
    const bool scaled = rule.slope != 1 || rule.intercept != 0;
    return rule.sign * ((scaled ? rule.slope * number + rule.intercept : number) - rule.iso);
  };
  double farthest = 0;
  bool usable = true;
  given.eachPoint([&](std::size_t x, std::size_t y, std::size_t z) {
    const double value = field(given.sample(x, y, z));
    usable =
        usable && std::isfinite(value) && std::abs(rule.sign * value + rule.iso) <= rule.largest;
    farthest = std::max(farthest, std::abs(value));
  });
  ASSERT_EQ(signs.usable, usable) << "seed " << seed;
  ASSERT_EQ(firstUnusable(given.box, rule).has_value(), !usable);
  if (!usable) return;
  EXPECT_EQ(signs.farthest, farthest);
  const SampleField looked(given.box, rule, 77);
  std::size_t inside = 0;
  given.eachPoint([&](std::size_t x, std::size_t y, std::size_t z) {
    const double value = field(given.sample(x, y, z));
    inside += value < 0 ? 1 : 0;
    ASSERT_EQ(isInside(signs, x, y, z), value < 0)
        << "seed " << seed << ", (" << x << ", " << y << ", " << z << "): " << value;
    ASSERT_EQ(
        looked.at(blockOf(x, y, z), static_cast<unsigned>(64 * (x % 8) + 8 * (y % 8) + z % 8)),
        value);
  });
  EXPECT_EQ(looked.at(blockOf(given.box.size[0] + 7, 0, 0), 0), 77);
  EXPECT_EQ(looked.at({0, -1, 0}, 0), 77);
  // Nothing but the points of the box is inside.
  std::size_t counted = 512 * signs.tiles.size();
  for (const Block& block : signs.blocks) {
    for (const std::uint64_t word : block.inside) counted += std::popcount(word);
  }
  EXPECT_EQ(counted, inside);
}

/// A slope through the box, so that there are blocks of all kinds, and some noise.
auto slopeOf(double scale, double noise) {
  return [=](std::mt19937& random, std::size_t x, std::size_t y, std::size_t z) {
    return scale * (static_cast<double>(x + y) - static_cast<double>(z) - 9 +
                    noise * std::uniform_real_distribution<>(-1, 1)(random));
  };
}

template <class T>
void expectAllRules(SampleType type) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    const auto slope = slopeOf(seed % 2 == 0 ? 1 : 3, seed % 3);
    const auto sample = [&](std::mt19937& random, auto... at) {
      const double shift = std::is_unsigned_v<T> ? 100 : 0;
      return static_cast<T>(slope(random, at...) + shift);
    };
    const double iso = std::is_unsigned_v<T> ? 100 : 0;
    SampleRule rule;
    rule.sign = -1;
    rule.iso = iso;
    expectDefinition<T>(type, rule, seed, sample);
    rule.iso = iso + 0.3;
    expectDefinition<T>(type, rule, seed, sample);
    rule.slope = -0.7;
    rule.intercept = 1.3;
    expectDefinition<T>(type, rule, seed, sample);
    rule.largest = 9;
    expectDefinition<T>(type, rule, seed, sample);
    rule = {};
    expectDefinition<T>(type, rule, seed, sample);
    rule.slope = 0.25;
    expectDefinition<T>(type, rule, seed, sample);
  }
}

TEST(SampleBox, SignsAndFieldAreThoseOfTheRuleForEveryTypeAndOrder) {
  expectAllRules<std::int8_t>(SampleType::Int8);
  expectAllRules<std::uint8_t>(SampleType::UInt8);
  expectAllRules<std::int16_t>(SampleType::Int16);
  expectAllRules<std::uint16_t>(SampleType::UInt16);
  expectAllRules<std::int32_t>(SampleType::Int32);
  expectAllRules<std::uint32_t>(SampleType::UInt32);
  expectAllRules<std::int64_t>(SampleType::Int64);
  expectAllRules<std::uint64_t>(SampleType::UInt64);
  expectAllRules<float>(SampleType::Float32);
  expectAllRules<double>(SampleType::Float64);
}

TEST(SampleBox, NumbersAtTheEndsOfFloatingPointAreJudgedAsTheyAre) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> ends = {0.0F,
                                   -0.0F,
                                   std::numeric_limits<float>::denorm_min(),
                                   -std::numeric_limits<float>::denorm_min(),
                                   std::numeric_limits<float>::max(),
                                   std::numeric_limits<float>::lowest(),
                                   std::nextafter(1.0F, 2.0F),
                                   1.0F,
                                   kInfinity,
                                   -kInfinity,
                                   std::numeric_limits<float>::quiet_NaN(),
                                   -std::numeric_limits<float>::quiet_NaN()};
  for (unsigned seed = 0; seed < 400; ++seed) {
    // Most boxes are usable: what is not finite is rare.
    const auto sample = [&](std::mt19937& random, auto...) {
      return ends[random() % (random() % 5000 == 0 ? ends.size() : 8)];
    };
    SampleRule rule;
    rule.floats = true;
    expectDefinition<float>(SampleType::Float32, rule, seed, sample);
    rule.sign = -1;
    for (const double iso : {0.0, -0.0, 1.0, 1 + 1e-9, 1e-300, -1e-300}) {
      rule.iso = iso;
      expectDefinition<float>(SampleType::Float32, rule, seed, sample);
    }
  }
}

TEST(SampleBox, MasksAreWhatIsNotZeroOrEqualsTheLabel) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    const Random<std::int16_t> labels(SampleType::Int16, random, [&](std::size_t x, auto...) {
      return static_cast<std::int16_t>(x < 9 ? -3 : static_cast<int>(random() % 3) - 1);
    });
    const Random<std::uint8_t> bools(SampleType::Bool, random, [&](auto...) {
      return static_cast<std::uint8_t>(random() % 3 == 0 ? 0 : random() % 256);
    });
    const Random<float> floats(SampleType::Float32, random, [&](auto...) {
      return random() % 9 == 0 ? std::nanf("") : static_cast<float>(random() % 3);
    });
    SampleRule rule;
    rule.mask = true;
    const auto check = [&](const auto& given, auto expected) {
      const SampleSigns signs = signsOf(given.box, rule);
      EXPECT_TRUE(signs.usable);
      given.eachPoint([&](std::size_t x, std::size_t y, std::size_t z) {
        ASSERT_EQ(isInside(signs, x, y, z), expected(given.sample(x, y, z))) << "seed " << seed;
      });
    };
    check(bools, [](std::uint8_t sample) { return sample != 0; });
    rule.label = -3;
    check(labels, [](std::int16_t sample) { return sample == -3; });
    rule.label = 2;
    check(floats, [](float sample) { return sample == 2; });
    rule.label = 40000;
    check(labels, [](std::int16_t) { return false; });
  }
}

/// Samples of the rule's outside value are outside, have the field beyond the box, and count
/// neither for what is usable nor for the farthest value; all others are as without it.
template <class T>
void expectNoData(SampleType type, SampleRule rule, double outside, T noData, unsigned seed) {
  std::mt19937 random(seed);
  const Random<T> given(type, random, [&](std::size_t x, auto...) {
    return random() % 4 == 0 || x < 3 ? noData : static_cast<T>(static_cast<int>(random() % 9) - 4);
  });
  rule.outside = outside;
  const SampleSigns signs = signsOf(given.box, rule);
  ASSERT_TRUE(signs.usable);
  EXPECT_FALSE(firstUnusable(given.box, rule));
  const SampleField looked(given.box, rule, 77);
  double farthest = 0;
  given.eachPoint([&](std::size_t x, std::size_t y, std::size_t z) {
    const T sample = given.sample(x, y, z);
    const bool isData = std::memcmp(&sample, &noData, sizeof sample) != 0;
    const double field =
        rule.sign * (rule.slope * static_cast<double>(sample) + rule.intercept - rule.iso);
    if (isData) farthest = std::max(farthest, std::abs(field));
    ASSERT_EQ(isInside(signs, x, y, z), isData && field < 0) << "seed " << seed;
    ASSERT_EQ(
        looked.at(blockOf(x, y, z), static_cast<unsigned>(64 * (x % 8) + 8 * (y % 8) + z % 8)),
        isData ? field : 77);
  });
  EXPECT_EQ(signs.farthest, farthest);
}

TEST(SampleBox, SamplesThatAreNoDataLieOutside) {
  SampleRule below;
  below.iso = 0.5;
  SampleRule scaled = below;
  scaled.slope = 0.1;
  scaled.intercept = 3;
  scaled.iso = 3.05;
  SampleRule floats = below;
  floats.floats = true;
  for (unsigned seed = 0; seed < 40; ++seed) {
    expectNoData<float>(SampleType::Float32, floats, std::nan(""), std::nanf(""), seed);
    expectNoData<float>(SampleType::Float32, floats, -2000.1, -2000.1F, seed);
    expectNoData<double>(SampleType::Float64, below, -2000.1, -2000.1, seed);
    expectNoData<double>(SampleType::Float64, below, -INFINITY, -INFINITY, seed);
    expectNoData<std::int16_t>(SampleType::Int16, below, -2000, -2000, seed);
    // -32 is stored, which is -0.2 in doubles but for the last digit.
    expectNoData<std::int16_t>(SampleType::Int16, scaled, -0.2, -32, seed);
    expectNoData<std::int8_t>(SampleType::Int8, below, -100, -100, seed);
  }
}

TEST(SampleBox, ABoxWithoutDataIsOutside) {
  const std::vector<float> nothing(27, std::nanf(""));
  const SampleBox box{SampleType::Float32,
                      reinterpret_cast<const std::byte*>(nothing.data()),
                      {3, 3, 3},
                      {36, 12, 4}};
  SampleRule rule;
  rule.floats = true;
  EXPECT_FALSE(signsOf(box, rule).usable);
  rule.outside = std::nan("");
  const SampleSigns signs = signsOf(box, rule);
  EXPECT_TRUE(signs.usable);
  EXPECT_TRUE(signs.blocks.empty() && signs.tiles.empty());
  EXPECT_EQ(signs.farthest, 0);
}

TEST(SampleBox, ArraysHaveValuesBelowInsideOnRequest) {
  const auto rule = arrayRule(SampleType::UInt8, "uint8", ArrayInside{.iso = 9, .below = true});
  ASSERT_TRUE(rule);
  EXPECT_EQ(rule->sign, 1);
  EXPECT_EQ(rule->iso, 9);
  EXPECT_FALSE(arrayRule(SampleType::Int16, "int16", ArrayInside{.label = 3, .outside = 0.0}));
}

TEST(FrameLayer, AThinBoxOfSamplesThatAreAllInsideIsNotTooBareForItsSize) {
  // Its blocks are tiles, with more faces than a file without stored blocks may have.
  const std::vector<std::uint8_t> ones(std::size_t{8} * 1600 * 1600, 1);
  const SampleBox box{SampleType::UInt8,
                      reinterpret_cast<const std::byte*>(ones.data()),
                      {8, 1600, 1600},
                      {1600 * 1600, 1600, 1}};
  SampleRule rule;
  rule.sign = -1;
  rule.iso = 0.5;
  SampleSigns signs = signsOf(box, rule);
  ASSERT_TRUE(signs.usable);
  EXPECT_EQ(signs.tiles.size(), 40'000U);
  const auto outside = fieldOutside(rule, signs.farthest);
  ASSERT_TRUE(outside);
  const auto layer = FrameLayer::of(frameOf(box, rule, std::move(signs), *outside, 0, nullptr),
                                    Lattice{}, kLargeFrame);
  ASSERT_TRUE(layer) << layer.error().text();
  EXPECT_GT(layer->vertexCount(), 2U * 1600 * 1600);
}

}  // namespace
}  // namespace t4d::voxel4d
