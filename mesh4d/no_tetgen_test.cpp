#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/cap.h"

namespace t4d::mesh4d {
namespace {

TEST(Cap, WithoutTetGenTheErrorNamesTheWayOut) {
  const auto cap = fillSolid(fixtures::cube(1), CapMethod::TetGen);
  ASSERT_FALSE(cap);
  EXPECT_EQ(cap.error().code, ErrorCode::Unsupported);
  EXPECT_EQ(cap.error().remedy, Remedy::ConeCaps);
}

}  // namespace
}  // namespace t4d::mesh4d
