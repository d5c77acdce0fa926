#include "model/box_tree.h"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

template <int Dimension>
Bounds<Dimension> randomBox(std::mt19937& random) {
  std::uniform_real_distribution<double> at(-1, 1);
  Bounds<Dimension> box;
  for (int corner = 0; corner < 2; ++corner) {
    box.add(Bounds<Dimension>::Point::NullaryExpr([&] { return at(random); }));
  }
  return box;
}

template <int Dimension>
void findsWhatOverlaps(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Bounds<Dimension>> boxes;
  for (unsigned i = 0; i < seed; ++i) boxes.push_back(randomBox<Dimension>(random));
  boxes.emplace_back();  // empty
  const BoxTree<Dimension> tree(boxes);
  for (int k = 0; k < 20; ++k) {
    const Bounds<Dimension> box = randomBox<Dimension>(random);
    std::multiset<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < seed; ++i) {
      if (overlap(boxes[i], box)) expected.insert(i);
    }
    std::multiset<std::uint32_t> found;
    tree.visitOverlapping(box, [&](std::uint32_t number) { found.insert(number); });
    EXPECT_EQ(found, expected) << seed;
    EXPECT_EQ(tree.anyOverlapping(box, [](std::uint32_t) { return true; }), !expected.empty());
  }
}

TEST(BoxTree, FindsWhatOverlapsOnce) {
  for (const unsigned seed : {0U, 1U, 4U, 5U, 64U, 300U}) {
    findsWhatOverlaps<3>(seed);
    findsWhatOverlaps<4>(seed);
  }
}

TEST(BoxTree, WidensInSpaceAlone) {
  const Bounds4 box = widened({Point4(0, 0, 0, 1), Point4(1, 1, 1, 2)}, 0.5);
  EXPECT_EQ(box.min, Point4(-0.5, -0.5, -0.5, 1));
  EXPECT_EQ(box.max, Point4(1.5, 1.5, 1.5, 2));
}

}  // namespace
}  // namespace t4d::model
