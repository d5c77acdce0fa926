#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "t4d/model/slab.h"

namespace t4d::tools {

/// Shows the progress of a long job on standard error, with the mean rate so far where it is known
/// how much there is to do. On a terminal: a bar, after half a second, erased at the end.
/// Elsewhere, such as in a log: a line every ten seconds.
class ProgressBar {
 public:
  /// Output and clock (in seconds).
  struct Console {
    bool terminal;
    std::function<double()> now;
    std::function<void(const std::string&)> print;
  };
  static Console standardError();
  /// From now on no bar prints anything.
  static void silence();

  explicit ProgressBar(std::string title, Console console = standardError());
  /// Of a job of `total` units, such as "frames"; without a rate if `total` is 0.
  ProgressBar(std::string title, std::uint64_t total, std::string units,
              Console console = standardError());
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// To pass as a model::Progress; valid as long as the bar exists.
  model::Progress callback();
  /// The same for the next of several parts of the job, which has so many of its units.
  model::Progress part(std::uint64_t units);

 private:
  void show(double fraction);
  /// ", 12,345 frames a second"; empty if unknown.
  std::string rate(double fraction, double seconds) const;

  std::string title_;
  std::uint64_t total_ = 0;
  std::string units_;
  std::uint64_t parted_ = 0;  // units of the parts up to now
  Console console_;
  double begun_;
  double shown_ = 0;  // time of the last output; 0 if none
};

}  // namespace t4d::tools
