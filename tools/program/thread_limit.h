#pragma once

#include <optional>

#include <CLI/CLI.hpp>
#include <tbb/global_control.h>

#include "tools/program/option_checks.h"

namespace t4d::tools {

/// Limits the number of threads while it exists; without a number there is one per processor.
/// Results are the same for any number.
class ThreadLimit {
 public:
  explicit ThreadLimit(std::optional<int> threads) {
    if (!threads) return;
    control_.emplace(tbb::global_control::max_allowed_parallelism,
                     static_cast<std::size_t>(*threads));
  }

 private:
  std::optional<tbb::global_control> control_;
};

/// Adds `--threads`.
inline void addThreadsOption(CLI::App& command, std::optional<int>& threads) {
  command
      .add_option("--threads", threads, "Maximum number of threads (default: one per processor)")
      ->check(wholeNumber(1, 1024));
}

}  // namespace t4d::tools
