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

/// Two digits or more, with commas: "0.25", "3.4", "12,345", "1.2 million".
std::string roundedNumber(double number) {
  if (number < 1) return fmt::format("{:.2g}", number);
  if (number < 10) return fmt::format("{:.1f}", number);
  if (number >= 1e6) return fmt::format("{:.1f} million", number / 1e6);
  const auto whole = static_cast<std::uint64_t>(number + 0.5);
  return whole < 1000 ? fmt::format("{}", whole)
                      : fmt::format("{},{:03}", whole / 1000, whole % 1000);
}

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

ProgressBar::ProgressBar(std::string title, std::uint64_t total, std::string units, Console console)
    : ProgressBar(std::move(title), std::move(console)) {
  total_ = total;
  units_ = std::move(units);
}

ProgressBar::~ProgressBar() {
  if (console_.terminal && shown_ > 0) console_.print("\r\033[K");
}

model::Progress ProgressBar::callback() {
  return [this](double fraction) { show(fraction); };
}

model::Progress ProgressBar::part(std::uint64_t units) {
  if (total_ == 0) return callback();
  const auto before = static_cast<double>(parted_);
  parted_ += units;
  return [this, before, units](double fraction) {
    show((before + fraction * static_cast<double>(units)) / static_cast<double>(total_));
  };
}

std::string ProgressBar::rate(double fraction, double seconds) const {
  if (total_ == 0 || !(fraction > 0) || !(seconds > 0)) return {};
  return fmt::format(", {} {} a second",
                     roundedNumber(fraction * static_cast<double>(total_) / seconds), units_);
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
    console_.print(fmt::format("t4d: {}: {:.0f} %{}, {:.0f} s left\n", title_, fraction * 100,
                               rate(fraction, time - begun_), left));
    return;
  }
  // All of it in a line of 80 columns.
  const int width = total_ > 0 ? 20 : 40;
  const int filled = static_cast<int>(fraction * width);
  console_.print(fmt::format("\r\033[K{} [{:=<{}}{:{}}] {:3.0f} %{}, {:.0f} s left", title_, "",
                             filled, "", width - filled, fraction * 100,
                             rate(fraction, time - begun_), left));
}

}  // namespace t4d::tools
