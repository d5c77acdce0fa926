#include "model/parallel.h"

#include <atomic>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

TEST(Parallel, EachNumberHasItsTurnOnce) {
  for (const std::size_t count : {0U, 1U, 1000U}) {
    std::vector<std::atomic<int>> calls(count);
    forEach(count, [&](std::size_t i) { ++calls[i]; });
    forEachTask(count, [&](std::size_t i) { ++calls[i]; });
    forRanges(0, count, 7, [&](std::size_t begin, std::size_t end) {
      EXPECT_LE(end - begin, 7U);
      while (begin < end) ++calls[begin++];
    });
    for (const std::atomic<int>& one : calls) EXPECT_EQ(one.load(), 3);
  }
}

/// Sums of doubles depend on their order: this one on the number of values alone.
TEST(Parallel, ReduceHalvesRangesWhateverTheNumberOfThreads) {
  std::mt19937 random(1);
  std::vector<double> values(10'001);
  for (double& value : values) value = std::ldexp(static_cast<double>(random()), random() % 60);
  const auto add = [&](std::size_t begin, std::size_t end, double sum) {
    return std::accumulate(&values[begin], &values[end - 1] + 1, sum);
  };
  const auto half = [&](const auto& self, std::size_t begin, std::size_t end) -> double {
    if (end - begin <= 16) return add(begin, end, 0);
    const std::size_t middle = begin + (end - begin) / 2;
    return self(self, begin, middle) + self(self, middle, end);
  };
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const ThreadLimit limit(threads);
    EXPECT_EQ(reduce<double>(values.size(), 16, add, std::plus<>()), half(half, 0, values.size()));
  }
}

TEST(Parallel, SortsAndWorksTogetherAndAside) {
  std::vector<int> values(5000);
  std::iota(values.rbegin(), values.rend(), 0);
  int first = 0;
  int second = 0;
  Aside aside;
  aside.begin([&] { second = 2; });
  together([&] { model::sort(values.begin(), values.end()); }, [&] { first = 1; });
  aside.wait();
  EXPECT_TRUE(std::ranges::is_sorted(values));
  EXPECT_EQ(first + second, 3);
}

TEST(Parallel, ValuesOfThreadsAddUp) {
  PerThread<int> counts([] { return 0; });
  forEach(1000, [&](int) { ++counts.local(); });
  int sum = 0;
  counts.each([&](int count) { sum += count; });
  EXPECT_EQ(sum, 1000);
}

TEST(Parallel, TakesItemsInOrderUntilOneIsEnough) {
  std::vector<std::size_t> taken;
  inOrder<std::size_t>(
      100, [](std::size_t i) { return i * i; },
      [&](std::size_t item) {
        taken.push_back(item);
        return item < 100;
      });
  ASSERT_EQ(taken.size(), 11U);
  EXPECT_EQ(taken.back(), 100U);
}

}  // namespace
}  // namespace t4d::model
