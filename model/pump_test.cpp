#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "model/parallel.h"
#include "model/shared_parts.h"
#include "t4d/mesh.h"

namespace t4d::model {
namespace {

constexpr std::size_t kSlabs = 60;

/// Slabs that last from their number to the next, and take longer the smaller that is modulo 5.
class Slow : public Source {
 public:
  explicit Slow(std::optional<std::uint64_t> cells, std::size_t broken = kSlabs)
      : cells_(cells), broken_(broken) {}

  std::size_t slabCount() const override { return kSlabs; }
  TimeSpan timeSpan(std::size_t index) const override {
    return {static_cast<double>(index), static_cast<double>(index + 1)};
  }
  std::optional<std::uint64_t> cellCount(std::size_t /*index*/) const override { return cells_; }
  Result<std::shared_ptr<const Slab>> slab(std::size_t index) const override {
    if (index == broken_) return invalid("broken");
    const int now = ++alive_;
    for (int most = most_; now > most && !most_.compare_exchange_weak(most, now);) {
    }
    std::this_thread::sleep_for(std::chrono::microseconds(100 * (5 - index % 5)));
    return std::shared_ptr<const Slab>(new Slab{static_cast<double>(index)}, [this](auto* slab) {
      delete slab;
      --alive_;
    });
  }

  int most() const { return most_; }

 private:
  std::optional<std::uint64_t> cells_;
  std::size_t broken_;
  mutable std::atomic<int> alive_ = 0;
  mutable std::atomic<int> most_ = 0;
};

class Times : public Sink {
 public:
  struct Time : Prepared {
    double time = 0;
  };
  Result<void> put(const Slab& slab) override { return putPrepared(slab, prepare(slab).get()); }
  std::unique_ptr<Prepared> prepare(const Slab& slab) const override {
    auto prepared = std::make_unique<Time>();
    prepared->time = slab.timeBegin;
    return prepared;
  }
  Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
    EXPECT_EQ(slab.timeBegin, static_cast<Time*>(prepared)->time);
    times.push_back(slab.timeBegin);
    if (refuse && times.size() == *refuse) return invalid("enough");
    return {};
  }

  std::vector<double> times;
  std::optional<std::size_t> refuse;
};

TEST(Pump, PutsSlabsInOrderWithWhatWasPreparedOfThem) {
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const ThreadLimit control(threads);
    const Slow source(10);
    Times times;
    double progress = 0;
    ASSERT_TRUE(pump(source, times, [&](double fraction) {
      EXPECT_GE(fraction, progress);
      progress = fraction;
      return true;
    }));
    EXPECT_EQ(progress, 1);
    ASSERT_EQ(times.times.size(), kSlabs);
    for (std::size_t i = 0; i < kSlabs; ++i) EXPECT_EQ(times.times[i], static_cast<double>(i));
  }
}

TEST(Pump, HasTwoSlabsInMemoryUnlessTheyAreKnownToBeSmall) {
  const ThreadLimit control(4);
  const auto mostOf = [](std::optional<std::uint64_t> cells) {
    const Slow source(cells);
    Times times;
    EXPECT_TRUE(pump(source, times));
    return source.most();
  };
  EXPECT_LE(mostOf({}), 2);
  EXPECT_LE(mostOf(std::uint64_t{1} << 30), 2);
  EXPECT_LE(mostOf(1), static_cast<int>(2 * threadCount()));
}

TEST(Pump, StopsWhenTold) {
  const Slow source(10);
  Times times;
  const auto done = pump(source, times, [&](double) { return times.times.size() < 3; });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::Failed);
  EXPECT_EQ(done.error().message, "stopped");
  EXPECT_EQ(times.times.size(), 3U);
}

TEST(Pump, EndsAtTheFirstFailure) {
  const Slow broken(10, 33);
  Times times;
  EXPECT_EQ(pump(broken, times).error().message, "broken");
  EXPECT_EQ(times.times.size(), 33U);
  const Slow source(10);
  Times few;
  few.refuse = 7;
  EXPECT_EQ(pump(source, few).error().message, "enough");
  EXPECT_EQ(few.times.size(), 7U);
}

TEST(SharedParts, AreMadeOnceAndForgottenWithTheirLastUser) {
  SharedParts<int, int> parts;
  std::atomic<int> made = 0;
  const auto get = [&](int key) {
    return *parts.get(key, [&]() -> Result<int> {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      ++made;
      return 10 * key;
    });
  };
  inOrder<std::shared_ptr<const int>>(
      20, 8, [&](std::size_t) { return get(3); },
      [](const std::shared_ptr<const int>& part) {
        EXPECT_EQ(*part, 30);
        return true;
      });
  EXPECT_EQ(made, 1);
  EXPECT_EQ(*parts.last(3), 30);
  const auto held = get(4);
  EXPECT_EQ(parts.last(3), nullptr);
  get(3);
  EXPECT_EQ(made, 3);
  EXPECT_EQ(get(4), held);
  EXPECT_EQ(made, 3);
}

TEST(SharedParts, ThatCouldNotBeMadeAreTriedAgain) {
  SharedParts<int, int> parts;
  EXPECT_FALSE(parts.get(1, []() -> Result<int> { return invalid("not yet"); }));
  EXPECT_EQ(parts.last(1), nullptr);
  EXPECT_EQ(**parts.get(1, []() -> Result<int> { return 5; }), 5);
}

}  // namespace
}  // namespace t4d::model
