#include "voxel4d/point_field_parts.h"

#include <algorithm>
#include <fstream>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "voxel4d/point_field.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Values at a third of the points, none of them in planes 24 to 39.
PointField thirds(bool whole) {
  PointField field;
  field.name = "thirds";
  field.lattice = {0.3, model::Point3(-3.1, 5, 7)};
  field.counts = {61, 9, 17};
  field.whole = whole;
  field.value = [](const std::array<std::uint32_t, 3>& at, double& value) {
    value = 100.1 * at[0] + 10.3 * at[1] - at[2];
    return (at[0] + at[1] + at[2]) % 3 == 0 && (at[0] < 24 || at[0] >= 40);
  };
  return field;
}

class PointFieldParts : public testing::Test {
 protected:
  fs::path write(const std::string& name, PointField field, std::uint64_t number,
                 std::uint64_t count) {
    field.part = {{number, count}, {{"input", "bolt"}}};
    const auto bytes = writePointField(folder_ / name, field);
    EXPECT_TRUE(bytes) << bytes.error().text();
    return folder_ / name;
  }
  std::vector<fs::path> writeParts(const PointField& field, std::uint64_t count) {
    std::vector<fs::path> parts;
    for (std::uint64_t k = 1; k <= count; ++k) {
      parts.push_back(write(std::to_string(k) + ".vdb", field, k, count));
    }
    return parts;
  }
  void refuses(const std::vector<fs::path>& parts, const std::string& expected) {
    const auto joined = joinPointFields(parts, folder_ / "no.vdb");
    ASSERT_FALSE(joined) << expected;
    EXPECT_THAT(joined.error().text(), HasSubstr(expected));
    EXPECT_EQ(joined.error().code, ErrorCode::InvalidInput);
    EXPECT_FALSE(fs::exists(folder_ / "no.vdb"));
  }

  platform::TestFolder folder_;
};

TEST_F(PointFieldParts, JoinToTheBytesOfTheWhole) {
  for (const bool whole : {false, true}) {
    for (const double voxelSize : {0.3, 1e-4}) {
      PointField field = thirds(whole);
      field.lattice.voxelSize = voxelSize;
      ASSERT_TRUE(writePointField(folder_ / "whole.vdb", field));
      for (const std::uint64_t count : {1, 3, 7, 8}) {
        std::vector<fs::path> parts = writeParts(field, count);
        std::ranges::reverse(parts);
        const auto joined = joinPointFields(parts, folder_ / "joined.vdb");
        ASSERT_TRUE(joined) << joined.error().text();
        EXPECT_EQ(joined->name, "thirds");
        EXPECT_EQ(joined->activePoints, 45U * 9 * 17 / 3);
        EXPECT_EQ(joined->bytes, fs::file_size(folder_ / "whole.vdb"));
        EXPECT_EQ(platform::contents(folder_ / "joined.vdb"),
                  platform::contents(folder_ / "whole.vdb"))
            << count;
      }
    }
  }
}

TEST_F(PointFieldParts, DivideThePlanesBetweenLeafNodes) {
  EXPECT_EQ(mostFieldParts(61), 8U);
  std::uint64_t planes = 0;
  for (std::uint64_t k = 1; k <= 5; ++k) {
    const model::PartRange own = planesOf({k, 5}, 61);
    EXPECT_EQ(own.begin, planes);
    EXPECT_EQ(own.begin % 8, 0U);
    planes = own.end;
  }
  EXPECT_EQ(planes, 61U);
}

TEST_F(PointFieldParts, OfOtherRunsAreRefused) {
  const PointField field = thirds(false);
  const std::vector<fs::path> parts = writeParts(field, 3);
  refuses({parts[0], parts[2]}, "3.vdb: part 2 of 3 is missing");
  refuses({parts[0], parts[1]}, "2.vdb: part 3 of 3 is missing");
  refuses({parts[2], parts[1]}, "2.vdb: part 1 of 3 is missing");
  refuses({parts[2], parts[0], parts[2], parts[1]}, "3.vdb: part 3 of 3 is given twice, also as");
  const auto differs = [&](const char* expected, const auto& change) {
    PointField other = field;
    change(other);
    refuses({parts[0], write("other.vdb", other, 2, 3), parts[2]}, expected);
  };
  differs("other.vdb: is of another run: its field is fourths, and that of ",
          [](PointField& other) { other.name = "fourths"; });
  differs("its type of values is int32", [](PointField& other) { other.whole = true; });
  differs("its voxel size is 0.3999", [](PointField& other) { other.lattice.voxelSize = 0.4; });
  differs("its first point is -3.1, 5, 8", [](PointField& other) { other.lattice.origin.z() = 8; });
  differs("its number of points is 61 x 9 x 18", [](PointField& other) { other.counts[2] = 18; });
  refuses({parts[0], write("other.vdb", field, 2, 4), parts[2]}, "its number of parts is 4");
  PointField other = field;
  other.part = {{2, 3}, {{"input", "nut"}}};
  ASSERT_TRUE(writePointField(folder_ / "other.vdb", other));
  refuses({parts[0], folder_ / "other.vdb", parts[2]}, "its input is nut");
  other.part->run = {{"time", "3"}};
  ASSERT_TRUE(writePointField(folder_ / "other.vdb", other));
  refuses({parts[0], folder_ / "other.vdb", parts[2]}, "its input is not there");
  other.part.reset();
  ASSERT_TRUE(writePointField(folder_ / "other.vdb", other));
  refuses({folder_ / "other.vdb"}, "other.vdb: is not a part of a field");
}

TEST_F(PointFieldParts, ThatAreDamagedAreRefused) {
  const std::vector<fs::path> parts = writeParts(thirds(true), 2);
  const std::string bytes = platform::contents(parts[1]);
  const auto refusesBytes = [&](const std::string& changed) {
    std::ofstream(parts[1], std::ios::binary) << changed;
    refuses(parts, "2.vdb: ");
  };
  for (std::size_t size = 0; size < bytes.size(); size += 97) refusesBytes(bytes.substr(0, size));
  for (std::size_t at = 0; at < bytes.size(); at += 53) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 1 << at % 8);
    refusesBytes(changed);
  }
}

}  // namespace
}  // namespace t4d::voxel4d
