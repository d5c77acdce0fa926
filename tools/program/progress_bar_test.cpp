#include "tools/program/progress_bar.h"

#include <gmock/gmock.h>

namespace t4d::tools {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Shows a job of `seconds` in a hundred parts, and returns what was printed.
std::vector<std::string> printed(bool terminal, double seconds, std::uint64_t total = 0) {
  std::vector<std::string> texts;
  double time = 1000;
  {
    ProgressBar bar(
        "working", total, "cells",
        {terminal, [&] { return time; }, [&](const std::string& text) { texts.push_back(text); }});
    const model::Progress show = bar.callback();
    for (int i = 0; i <= 100; ++i) {
      time = 1000 + seconds * i / 100;
      show(i / 100.0);
    }
  }
  return texts;
}

TEST(ProgressBar, PrintsALineEveryTenSecondsWithoutATerminal) {
  EXPECT_THAT(printed(false, 9), IsEmpty());
  EXPECT_THAT(printed(false, 25),
              ElementsAre("t4d: working: 40 %, 15 s left\n", "t4d: working: 80 %, 5 s left\n"));
  EXPECT_EQ(printed(false, 600).size(), 50U);  // a part takes six seconds: every other part
}

TEST(ProgressBar, TellsTheRateWhereItKnowsTheTotal) {
  const auto rateOf = [](std::uint64_t total) { return printed(false, 25, total).front(); };
  EXPECT_EQ(rateOf(30'500'000), "t4d: working: 40 %, 1.2 million cells a second, 15 s left\n");
  EXPECT_EQ(rateOf(1'000'000), "t4d: working: 40 %, 40,000 cells a second, 15 s left\n");
  EXPECT_EQ(rateOf(25'200), "t4d: working: 40 %, 1,008 cells a second, 15 s left\n");
  EXPECT_EQ(rateOf(25'000), "t4d: working: 40 %, 1,000 cells a second, 15 s left\n");
  EXPECT_EQ(rateOf(24'975), "t4d: working: 40 %, 999 cells a second, 15 s left\n");
  EXPECT_EQ(rateOf(85), "t4d: working: 40 %, 3.4 cells a second, 15 s left\n");
  EXPECT_EQ(rateOf(5), "t4d: working: 40 %, 0.2 cells a second, 15 s left\n");
  EXPECT_THAT(printed(true, 5, 1000).back(), "\r\033[K");
  EXPECT_THAT(printed(true, 5, 1000).front(), HasSubstr("%, 200 cells a second, "));
}

TEST(ProgressBar, PartsShareTheTotal) {
  std::vector<std::string> texts;
  double time = 1000;
  ProgressBar bar(
      "working", 40, "slabs",
      {false, [&] { return time; }, [&](const std::string& text) { texts.push_back(text); }});
  const model::Progress first = bar.part(10);
  time += 10;
  first(0.8);
  const model::Progress second = bar.part(30);
  time += 10;
  second(0.2);
  EXPECT_THAT(texts, ElementsAre("t4d: working: 20 %, 0.8 slabs a second, 40 s left\n",
                                 "t4d: working: 40 %, 0.8 slabs a second, 30 s left\n"));
}

TEST(ProgressBar, DrawsABarOnATerminalAndErasesIt) {
  EXPECT_THAT(printed(true, 0.4), IsEmpty());
  const auto texts = printed(true, 5);
  EXPECT_THAT(texts.front(), HasSubstr("working [===="));
  EXPECT_EQ(texts.back(), "\r\033[K");
}

}  // namespace
}  // namespace t4d::tools
