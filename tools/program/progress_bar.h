#pragma once

#include <functional>
#include <string>

#include "t4d/model/slab.h"

namespace t4d::tools {

/// Shows the progress of a long job on standard error. On a terminal: a bar, after half a second,
/// erased at the end. Elsewhere, such as in a log: a line every ten seconds.
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
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// To pass as a model::Progress; valid as long as the bar exists.
  model::Progress callback();

 private:
  void show(double fraction);

  std::string title_;
  Console console_;
  double begun_;
  double shown_ = 0;  // time of the last output; 0 if none
};

}  // namespace t4d::tools
