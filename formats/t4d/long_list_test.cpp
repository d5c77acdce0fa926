#include "formats/t4d/long_list.h"

#include <cstdlib>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "formats/t4d/index_chunk.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kManyRows = 100'003;  // more than are in memory

LongList<std::uint64_t> squares() {
  LongList<std::uint64_t> list;
  for (std::uint64_t i = 0; i < kManyRows; ++i) list.push_back(i * i);
  return list;
}

void expectSquares(const LongList<std::uint64_t>& list) {
  ASSERT_EQ(list.size(), kManyRows);
  for (const std::size_t i : {std::size_t{0}, std::size_t{70'000}, kManyRows - 1, std::size_t{5}}) {
    EXPECT_EQ(list[i], i * i);
  }
  std::uint64_t i = 0;
  for (const std::uint64_t square : list.all()) {
    ASSERT_EQ(square, i * i);
    ++i;
  }
  // These rows cross the end of those in the file.
  std::vector<std::uint64_t> some(90'000);
  list.rows().read(kManyRows - some.size(), some);
  EXPECT_EQ(some.front(), (kManyRows - some.size()) * (kManyRows - some.size()));
  EXPECT_EQ(some.back(), (kManyRows - 1) * (kManyRows - 1));
  EXPECT_FALSE(list.failed());
}

TEST(LongList, HasAllRowsInOrder) {
  const LongList<std::uint64_t> list = squares();
  expectSquares(list);
  const auto all = list.all();
  EXPECT_EQ(*std::ranges::lower_bound(all, 70'000ULL * 70'000 - 3), 70'000ULL * 70'000);
}

TEST(LongList, StaysInMemoryWhereThereIsNoRoomForAFile) {
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before == nullptr ? "" : before;
  setenv("TMPDIR", "/nowhere", 1);
  const LongList<std::uint64_t> list = squares();
  before == nullptr ? unsetenv("TMPDIR") : setenv("TMPDIR", kept.c_str(), 1);
  expectSquares(list);
}

TEST(LongList, KeepsRecordsWithAndWithoutExtents) {
  SlabList list;
  const IndexRecord without{8, 16, {1, 2, 3, 4}, {0.25, 0.5}};
  IndexRecord with = without;
  with.extent = {7, {{1, 2, 3}, {4, 5, 6}}};
  for (std::size_t i = 0; i < kManyRows; ++i) list.push_back(i % 2 == 0 ? without : with);
  EXPECT_EQ(list[0], without);
  EXPECT_FALSE(list[0].extent);
  EXPECT_EQ(list[1], with);
  EXPECT_EQ(list[1].extent, with.extent);
}

}  // namespace
}  // namespace t4d::formats
