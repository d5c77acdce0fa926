#include "model/voxel_size.h"

#include <limits>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

TEST(VoxelSize, IsARepresentableLength) {
  for (const double size : {1e-30, 1.0, 1e30}) EXPECT_TRUE(checkVoxelSize(size)) << size;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double size : {0.0, -1.0, 9e-31, 1.1e30, infinity, infinity - infinity}) {
    const auto checked = checkVoxelSize(size);
    ASSERT_FALSE(checked) << size;
    EXPECT_EQ(checked.error().remedy, Remedy::VoxelSize);
  }
  EXPECT_EQ(checkVoxelSize(0).error().text(),
            "voxels of 0 are requested; 1e-30 to 1e+30 are possible");
  EXPECT_EQ(checkVoxelSize(0, Remedy::RemeshSize).error().remedy, Remedy::RemeshSize);
}

TEST(VoxelSize, OfTooMuchMemoryIsRefusedWithWhatFits) {
  const Error error = tooMuchMemory({0.01, 56.1e9, 4e9}, "the stock needs", "0.04 fits");
  EXPECT_EQ(error.text(),
            "with a voxel size of 0.01 the stock needs about 56.10 GB of memory, more than the "
            "limit of 4.00 GB; 0.04 fits");
  EXPECT_EQ(error.remedy, Remedy::VoxelSize);
  EXPECT_EQ(memoryText(1), "1 bytes");
  EXPECT_EQ(memoryText(5e6), "5.0 MB");
  EXPECT_EQ(memoryText(1e40), "1e+31 GB");
}

}  // namespace
}  // namespace t4d::model
