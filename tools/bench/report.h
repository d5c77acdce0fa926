#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "platform/process.h"

namespace t4d::bench {

using platform::peakBytes;

/// Two operations timed in one run; only their ratio carries over to other machines.
struct Row {
  std::string what;
  double seconds = 0;
  std::string against;
  double againstSeconds = 0;

  double ratio() const { return seconds / againstSeconds; }
};

/// A single number, such as a size.
struct Figure {
  std::string what;
  double value = 0;
  std::string unit;
};

struct Report {
  std::string input;
  int repetitions = 0;
  std::vector<Row> rows;
  std::vector<Figure> figures;
};

/// Runs both in turn, `repetitions` times each, and returns the medians. Taking turns exposes both
/// to the same state of caches and disk.
Row compare(int repetitions, std::string what, const std::function<void()>& run,
            std::string against, const std::function<void()>& runAgainst);

double medianOf(std::vector<double> values);

/// The median of the seconds that `run` takes.
double medianSeconds(int repetitions, const std::function<void()>& run);

std::string textOf(const Report& report);
std::string jsonOf(const Report& report);

}  // namespace t4d::bench
