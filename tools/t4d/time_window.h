#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "tools/verbs/time_window.h"

namespace t4d::tools {

/// A part of the time: `--from` and `--to`.
struct TimeWindow : verbs::TimeWindow {
  void addTo(CLI::App& command);

  /// Why these options cannot be.
  std::optional<std::string> misuse() const;
};

}  // namespace t4d::tools
