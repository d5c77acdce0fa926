#include "tools/t4d/progress_bar.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "platform/process.h"

namespace t4d::tools {
namespace {

bool silent = false;
/// The one that draws itself: the last of those that exist.
std::atomic<const ProgressBar*> beating = nullptr;

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
  return {platform::standardErrorIsTerminal() && !dumb,
          [] {
            const auto now = std::chrono::steady_clock::now().time_since_epoch();
            return std::chrono::duration<double>(now).count();
          },
          [](const std::string& text) {
            std::fwrite(text.data(), 1, text.size(), stderr);
            std::fflush(stderr);
          },
          /*beats=*/true};
}

ProgressBar::ProgressBar(std::string title, Console console)
    : title_(std::move(title)), console_(std::move(console)), begun_(console_.now()) {
  start();
}

ProgressBar::ProgressBar(std::string title, std::uint64_t total, std::string units, Console console)
    : ProgressBar(std::move(title), std::move(console)) {
  const std::scoped_lock lock(mutex_);
  total_ = total;
  units_ = std::move(units);
}

ProgressBar::~ProgressBar() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
    beating = outer_;
  }
  if (console_.terminal && shown_ > 0) console_.print("\r\033[K");
}

void ProgressBar::start() {
  if (silent || !console_.terminal || !console_.beats) return;
  outer_ = beating.exchange(this);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    constexpr std::chrono::milliseconds kBeat(250);
    std::unique_lock lock(mutex_);
    while (!ends_.wait_for(lock, stop, kBeat, [&] { return stop.stop_requested(); })) {
      if (beating == this) draw();
    }
  });
}

void ProgressBar::beat() {
  const std::scoped_lock lock(mutex_);
  draw();
}

model::Progress ProgressBar::callback() {
  return [this](double fraction) { return show(fraction); };
}

model::Progress ProgressBar::part(std::uint64_t units) {
  if (total_ == 0) return callback();
  const auto before = static_cast<double>(parted_);
  parted_ += units;
  return [this, before, units](double fraction) {
    return show((before + fraction * static_cast<double>(units)) / static_cast<double>(total_));
  };
}

std::string ProgressBar::rate(double fraction, double seconds) const {
  if (total_ == 0 || !(fraction > 0) || !(seconds > 0)) return {};
  return fmt::format(", {} {} a second",
                     roundedNumber(fraction * static_cast<double>(total_) / seconds), units_);
}

bool ProgressBar::show(double fraction) {
  const std::scoped_lock lock(mutex_);
  fraction_ = fraction;
  draw();
  return true;
}

void ProgressBar::draw() {
  if (silent || !console_.terminal) return;
  constexpr double kHidden = 0.5;
  constexpr double kBetween = 0.1;
  const double fraction = fraction_;
  const double time = console_.now();
  if (time - begun_ < kHidden || time - shown_ < kBetween) return;
  shown_ = time;
  const std::string left =
      fraction > 0 ? fmt::format("{:.0f} s left", (time - begun_) * (1 - fraction) / fraction)
                   : fmt::format("{:.0f} s so far", time - begun_);
  // The whole bar fits in a line of 80 columns.
  const int width = total_ > 0 ? 20 : 40;
  const int filled = static_cast<int>(fraction * width);
  console_.print(fmt::format("\r\033[K{} [{:=<{}}{:{}}] {:3.0f} %{}, {}", title_, "", filled, "",
                             width - filled, fraction * 100, rate(fraction, time - begun_), left));
}

}  // namespace t4d::tools
