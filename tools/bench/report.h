#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "platform/process.h"

namespace t4d::bench {

using platform::peakBytes;

double medianOf(std::vector<double> values);

/// Two operations timed in one run; only their ratio carries over to other machines.
struct Row {
  std::string what;
  double seconds = 0;
  std::string against;
  double againstSeconds = 0;
  std::vector<double> ratios = {};  ///< one for each pair of runs, if they took turns

  /// The median of those of the pairs, which share the state of the machine.
  double ratio() const { return ratios.empty() ? seconds / againstSeconds : medianOf(ratios); }
  /// The median deviation of the pairs from the ratio, as a part of it; nothing without pairs.
  std::optional<double> noise() const;
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

/// The medians of the seconds of operations that took turns, run by run.
Row rowOfPairs(std::string what, const std::vector<double>& seconds, std::string against,
               const std::vector<double>& againstSeconds);

/// Runs both in turn, `repetitions` times each. Taking turns exposes both to the same state of
/// caches and disk.
Row compare(int repetitions, std::string what, const std::function<void()>& run,
            std::string against, const std::function<void()>& runAgainst);

/// The median of the seconds that `run` takes.
double medianSeconds(int repetitions, const std::function<void()>& run);

std::string textOf(const Report& report);
std::string jsonOf(const Report& report);

}  // namespace t4d::bench
