#include "platform/isolated.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace t4d::platform {
namespace {

using End = IsolatedWork::End;
constexpr WorkLimits kEnough{std::uint64_t{1} << 30, 60};

TEST(Isolated, ReturnsWhatTheWorkReturns) {
  std::string bytes;
  for (int i = 0; i < 1'000'000; ++i) bytes += static_cast<char>(i % 251);
  const auto done = runIsolated([&] { return bytes; }, kEnough);
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(done->end, End::Returned);
  EXPECT_TRUE(done->result == bytes);
}

TEST(Isolated, AnAssertionEndsTheWorkAlone) {
  const auto done = runIsolated(
      []() -> std::string {
        std::fputs("assertion failed\n", stderr);
        std::abort();
      },
      kEnough);
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(done->end, End::Crashed);
  EXPECT_EQ(done->signal, SIGABRT);
}

TEST(Isolated, AnExceptionIsACrash) {
  const auto done = runIsolated([]() -> std::string { throw std::runtime_error("no"); }, kEnough);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->end, End::Crashed);
}

TEST(Isolated, EndlessWorkRunsOutOfTime) {
  const auto done = runIsolated(
      []() -> std::string {
        std::atomic<bool> done = false;
        while (!done.load()) {
        }
        return {};
      },
      {kEnough.memoryBytes, 1});
  ASSERT_TRUE(done);
  EXPECT_EQ(done->end, End::OutOfTime);
}

TEST(Isolated, OtherThreadsMayHoldTheAllocatorWhenItStarts) {
  std::vector<std::jthread> others;
  for (int i = 0; i < 4; ++i) {
    others.emplace_back([](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        std::vector<std::string> held;
        for (int k = 0; k < 1000; ++k) held.emplace_back(std::size_t{100} + k, 'x');
      }
    });
  }
  for (int run = 0; run < 100; ++run) {
    const auto done = runIsolated(
        [] {
          std::vector<std::string> all;
          for (int k = 0; k < 1000; ++k) all.emplace_back(std::size_t{100} + k, 'y');
          return all.back();
        },
        kEnough);
    ASSERT_TRUE(done) << done.error().text();
    EXPECT_EQ(done->end, End::Returned);
  }
}

#ifndef T4D_ADDRESS_SANITIZER
TEST(Isolated, GreedyWorkRunsOutOfMemory) {
  const auto done = runIsolated(
      [] {
        std::vector<std::string> all;
        for (;;) all.emplace_back(std::size_t{1} << 20, 'x');
        return std::string();
      },
      {std::uint64_t{256} << 20, 60});
  ASSERT_TRUE(done);
  EXPECT_EQ(done->end, End::OutOfMemory);
}
#endif

}  // namespace
}  // namespace t4d::platform
