#include "measure/contact_stretches.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace t4d::measure {
namespace {

/// Stretches among whole times, of which some touch, by pairs of cells of their own.
std::vector<ContactStretch> randomStretches(std::mt19937& random) {
  std::vector<ContactStretch> stretches(1 + random() % 12);
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    ContactStretch& stretch = stretches[i];
    stretch.begin = static_cast<double>(random() % 40);
    stretch.end = stretch.begin + static_cast<double>(random() % 6);
    stretch.first.a = CellNumber{0, i};
    stretch.last.b = CellNumber{0, i};
    stretch.overlaps = random() % 2 == 0;
    if (stretch.overlaps) stretch.crossing = {stretch.begin, stretch.end};
  }
  return stretches;
}

bool isIn(const std::vector<ContactStretch>& stretches, double time) {
  return std::ranges::any_of(
      stretches, [&](const auto& each) { return each.begin <= time && time <= each.end; });
}

TEST(ContactStretches, AreTheTimesThatWereAddedApartInAnyOrder) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<ContactStretch> given = randomStretches(random);
    ContactStretches stretches;
    for (const ContactStretch& each : given) stretches.add(each);
    const auto all = stretches.all();
    for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LT(all[i - 1].end, all[i].begin);
    for (double time = 0; time <= 46; time += 0.5) {
      EXPECT_EQ(stretches.includes(time, time), isIn(given, time));
    }
    for (const ContactStretch& each : all) {
      const auto isPart = [&](const auto& one) {
        return one.begin >= each.begin && one.end <= each.end;
      };
      EXPECT_EQ(each.overlaps, std::ranges::any_of(given, [&](const auto& one) {
                  return isPart(one) && one.overlaps;
                }));
      double longest = 0;
      for (const ContactStretch& one : given) {
        if (isPart(one) && one.overlaps) longest = std::max(longest, one.end - one.begin);
      }
      EXPECT_EQ(each.crossing.end - each.crossing.begin, longest);
      const ContactStretch& first = given[each.first.a->cell];
      const ContactStretch& last = given[each.last.b->cell];
      EXPECT_EQ(first.begin, each.begin);
      EXPECT_EQ(last.end, each.end);
    }
    std::ranges::shuffle(given, random);
    ContactStretches shuffled;
    for (const ContactStretch& each : given) shuffled.add(each);
    ASSERT_EQ(shuffled.all().size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(shuffled.all()[i].begin, all[i].begin);
      EXPECT_EQ(shuffled.all()[i].end, all[i].end);
      EXPECT_EQ(shuffled.all()[i].overlaps, all[i].overlaps);
      EXPECT_EQ(shuffled.all()[i].crossing.begin, all[i].crossing.begin);
      EXPECT_EQ(shuffled.all()[i].first.a->cell, all[i].first.a->cell);
      EXPECT_EQ(shuffled.all()[i].last.b->cell, all[i].last.b->cell);
    }
  }
}

TEST(ContactStretches, CoverSpansThatLieInOneThatOverlaps) {
  std::mt19937 random(13);
  for (int trial = 0; trial < 200; ++trial) {
    ContactStretches stretches;
    for (const ContactStretch& each : randomStretches(random)) stretches.add(each);
    for (double begin = 0; begin <= 46; begin += 0.5) {
      for (double end = begin; end <= begin + 6; end += 0.5) {
        bool includes = false;
        bool covers = false;
        for (const ContactStretch& each : stretches.all()) {
          if (begin < each.begin || end > each.end) continue;
          includes = true;
          covers = each.overlaps;
        }
        EXPECT_EQ(stretches.includes(begin, end), includes);
        EXPECT_EQ(stretches.covers(begin, end), covers);
      }
    }
  }
}

}  // namespace
}  // namespace t4d::measure
