#include "tools/t4d/progress_bar.h"

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

TEST(ProgressBar, PrintsNothingWithoutATerminal) { EXPECT_THAT(printed(false, 600), IsEmpty()); }

TEST(ProgressBar, TellsTheRateWhereItKnowsTheTotal) {
  const auto rateOf = [](std::uint64_t total) { return printed(true, 25, total).at(40); };
  EXPECT_THAT(rateOf(30'500'000), HasSubstr(" %, 1.2 million cells a second, "));
  EXPECT_THAT(rateOf(1'000'000), HasSubstr(" %, 40,000 cells a second, "));
  EXPECT_THAT(rateOf(25'200), HasSubstr(" %, 1,008 cells a second, "));
  EXPECT_THAT(rateOf(25'000), HasSubstr(" %, 1,000 cells a second, "));
  EXPECT_THAT(rateOf(24'975), HasSubstr(" %, 999 cells a second, "));
  EXPECT_THAT(rateOf(85), HasSubstr(" %, 3.4 cells a second, "));
  EXPECT_THAT(rateOf(5), HasSubstr(" %, 0.2 cells a second, "));
}

TEST(ProgressBar, PartsShareTheTotal) {
  std::vector<std::string> texts;
  double time = 1000;
  ProgressBar bar(
      "working", 40, "slabs",
      {true, [&] { return time; }, [&](const std::string& text) { texts.push_back(text); }});
  const model::Progress first = bar.part(10);
  time += 10;
  first(0.8);
  const model::Progress second = bar.part(30);
  time += 10;
  second(0.2);
  EXPECT_THAT(texts, ElementsAre(HasSubstr(" 20 %, 0.8 slabs a second, 40 s left"),
                                 HasSubstr(" 40 %, 0.8 slabs a second, 30 s left")));
}

TEST(ProgressBar, DrawsABarOnATerminalAndErasesIt) {
  EXPECT_THAT(printed(true, 0.4), IsEmpty());
  const auto texts = printed(true, 5);
  EXPECT_THAT(texts.front(), HasSubstr("working [===="));
  EXPECT_EQ(texts.back(), "\r\033[K");
}

TEST(ProgressBar, GoesOnWhileTheJobReportsNothing) {
  std::vector<std::string> texts;
  double time = 1000;
  ProgressBar bar("working", {true, [&] { return time; },
                              [&](const std::string& text) { texts.push_back(text); }});
  for (int i = 0; i < 4; ++i) {
    bar.beat();
    time += 1;
  }
  ASSERT_EQ(texts.size(), 3U);
  EXPECT_THAT(texts[0], HasSubstr("0 %, 1 s so far"));
  EXPECT_THAT(texts[2], HasSubstr("0 %, 3 s so far"));
}

}  // namespace
}  // namespace t4d::tools
