#include "tools/program/progress_bar.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>
#include <unistd.h>

namespace t4d::tools {
namespace {

bool silent = false;

}  // namespace

void ProgressBar::silence() { silent = true; }

ProgressBar::Console ProgressBar::standardError() {
  const char* terminal = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe)
  const bool dumb = terminal == nullptr || std::string_view(terminal) == "dumb";
  return {isatty(STDERR_FILENO) == 1 && !dumb,
          [] {
            const auto now = std::chrono::steady_clock::now().time_since_epoch();
            return std::chrono::duration<double>(now).count();
          },
          [](const std::string& text) {
            std::fwrite(text.data(), 1, text.size(), stderr);
            std::fflush(stderr);
          }};
}

ProgressBar::ProgressBar(std::string title, Console console)
    : title_(std::move(title)), console_(std::move(console)), begun_(console_.now()) {}

ProgressBar::~ProgressBar() {
  if (console_.terminal && shown_ > 0) console_.print("\r\033[K");
}

model::Progress ProgressBar::callback() {
  return [this](double fraction) { show(fraction); };
}

void ProgressBar::show(double fraction) {
  if (silent) return;
  const double hidden = console_.terminal ? 0.5 : 10;
  const double between = console_.terminal ? 0.1 : 10;
  const double time = console_.now();
  if (time - begun_ < hidden || time - shown_ < between) return;
  shown_ = time;
  const double left = fraction > 0 ? (time - begun_) * (1 - fraction) / fraction : 0;
  if (!console_.terminal) {
    console_.print(fmt::format("t4d: {}: {:.0f} %, {:.0f} s left\n", title_, fraction * 100, left));
    return;
  }
  constexpr int kWidth = 40;
  const int filled = static_cast<int>(fraction * kWidth);
  console_.print(fmt::format("\r\033[K{} [{:=<{}}{:{}}] {:3.0f} %  {:.0f} s left", title_, "",
                             filled, "", kWidth - filled, fraction * 100, left));
}

}  // namespace t4d::tools
