#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "tools/t4d/observer.h"

namespace t4d::tools {

/// Shows the progress of a long job on standard error, with the mean rate so far where it is known
/// how much there is to do. On a terminal: a bar, after half a second, erased at the end; it is
/// drawn again while the job reports nothing, so that its time goes on. Elsewhere, such as in a
/// log: nothing.
class ProgressBar : public Stage {
 public:
  /// Output and clock (in seconds).
  struct Console {
    bool terminal;
    std::function<double()> now;
    std::function<void(const std::string&)> print;
    bool beats = false;  ///< draw it again from a thread of its own
  };
  static Console standardError();
  /// From now on no bar prints anything.
  static void silence();

  explicit ProgressBar(std::string title, Console console = standardError());
  /// The bar of a job of `total` units, such as "frames"; without a rate if `total` is 0.
  ProgressBar(std::string title, std::uint64_t total, std::string units,
              Console console = standardError());
  ~ProgressBar() override;

  model::Progress callback() override;
  model::Progress part(std::uint64_t units) override;
  /// Draws what is known, as the thread does.
  void beat();

 private:
  void start();
  /// True: who watches a bar stops by a signal.
  bool show(double fraction);
  void draw();
  /// ", 12,345 frames a second"; empty if unknown.
  std::string rate(double fraction, double seconds) const;

  std::string title_;
  std::uint64_t total_ = 0;
  std::string units_;
  std::uint64_t parted_ = 0;  // units of the parts up to now
  Console console_;
  double begun_;
  double fraction_ = 0;
  double shown_ = 0;                    // time of the last output; 0 if none
  const ProgressBar* outer_ = nullptr;  // the one that drew itself before
  std::mutex mutex_;                    // of all that changes
  std::condition_variable_any ends_;
  std::jthread thread_;  // last, so that it ends first
};

}  // namespace t4d::tools
