#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/motion.h"

namespace t4d::tools {

/// `--angles`, `--quaternion`, `--length-unit` and `--time-unit`: what the names of the columns of
/// a table of poses may leave open.
struct MotionOptions {
  formats::MotionTableOptions table;

  void addTo(CLI::App& command);
  /// The options as arguments of a command.
  std::vector<std::string> arguments() const;
};

}  // namespace t4d::tools
