#include "tools/program/progress_bar.h"

#include <gmock/gmock.h>

namespace t4d::tools {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Shows a job of `seconds` in a hundred parts, and returns what was printed.
std::vector<std::string> printed(bool terminal, double seconds) {
  std::vector<std::string> texts;
  double time = 1000;
  {
    ProgressBar bar("working", {terminal, [&] { return time; },
                                [&](const std::string& text) { texts.push_back(text); }});
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

TEST(ProgressBar, DrawsABarOnATerminalAndErasesIt) {
  EXPECT_THAT(printed(true, 0.4), IsEmpty());
  const auto texts = printed(true, 5);
  EXPECT_THAT(texts.front(), HasSubstr("working [===="));
  EXPECT_EQ(texts.back(), "\r\033[K");
}

}  // namespace
}  // namespace t4d::tools
