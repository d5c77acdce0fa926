#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

/// A slab without thickness of `count` vertices at `time`: a lower layer, an upper layer or both.
Slab layerSlab(double time, std::uint32_t lower, std::uint32_t upper) {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = lower + upper;
  connectivity->lowerCount = lower;
  connectivity->upperCount = upper;
  connectivity->cells = {{0, 1, 2, 3}};
  Slab slab;
  slab.timeBegin = slab.timeEnd = time;
  for (std::uint32_t i = 0; i < lower; ++i) slab.vertices.emplace_back(i, 0, 0, time);
  for (std::uint32_t i = 0; i < upper; ++i) slab.vertices.emplace_back(i, 0, 0, time);
  slab.connectivity = connectivity;
  return slab;
}

TEST(Flatten, MergesSeamsAndNumbersCellsThroughTheWholeMesh) {
  Mesh mesh;
  ASSERT_TRUE(mesh.put(layerSlab(0, 0, 4)) && mesh.put(layerSlab(0, 4, 5)) &&
              mesh.put(layerSlab(0, 5, 0)));
  const auto flat = flatten(mesh);
  ASSERT_TRUE(flat) << flat.error().text();
  ASSERT_EQ(flat->vertices.rows(), 4 + 5);
  ASSERT_EQ(flat->cells.rows(), 3);
  for (Eigen::Index i = 0; i < 9; ++i) {
    EXPECT_EQ(flat->vertices.row(i), Eigen::RowVector4d(i < 4 ? i : i - 4, 0, 0, 0));
  }
  EXPECT_EQ(flat->cells.row(1), (Eigen::Matrix<std::uint32_t, 1, 4>(0, 1, 2, 3)));
  EXPECT_EQ(flat->cells.row(2), (Eigen::Matrix<std::uint32_t, 1, 4>(4, 5, 6, 7)));
}

TEST(Flatten, RefusesSlabsThatDoNotJoin) {
  Mesh mesh;
  ASSERT_TRUE(mesh.put(layerSlab(0, 0, 4)) && mesh.put(layerSlab(0, 5, 0)));
  const auto flat = flatten(mesh);
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().text(),
            "slab 1: its lower layer is not the upper layer of the one before");
}

TEST(Flatten, OfNothingIsEmpty) {
  const auto flat = flatten(Mesh());
  ASSERT_TRUE(flat);
  EXPECT_EQ(flat->vertices.rows(), 0);
  EXPECT_EQ(flat->cells.rows(), 0);
}

TEST(Tee, HandsSlabsToEverySinkUntilOneFails) {
  class Full : public Sink {
   public:
    Result<void> put(const Slab&) override { return invalid("full"); }
  } full;
  Mesh first;
  Mesh last;
  NullSink nothing;
  Tee good({&first, &nothing, &last});
  ASSERT_TRUE(good.put(layerSlab(0, 0, 4)));
  EXPECT_EQ(first.slabCount(), 1U);
  EXPECT_EQ(last.slabCount(), 1U);
  Tee bad({&first, &full, &last});
  EXPECT_FALSE(bad.put(layerSlab(0, 4, 0)));
  EXPECT_EQ(first.slabCount(), 2U);
  EXPECT_EQ(last.slabCount(), 1U);
}

}  // namespace
}  // namespace t4d::model
