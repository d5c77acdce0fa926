#pragma once

#include <filesystem>
#include <string>

#include "t4d/error.h"
#include "tools/bench/report.h"

namespace t4d::bench {

struct WholeCommandsOptions {
  int repetitions = 3;
  bool large = false;             ///< also 1.7 GB of samples
  std::string mesh = {};          ///< of which level sets are made; "" for a bolt
  std::filesystem::path program;  ///< t4d
  std::filesystem::path folder;   ///< for the inputs and outputs
  /// Another t4d, with which each command is compared in pairs of runs, on one thread and in
  /// seconds of the processor; "" for none.
  std::filesystem::path against = {};
  std::string only = {};  ///< only commands whose names contain this
};

/// Times commands on files as a user runs them, from start to end: frames that others write and
/// their surfaces by others (peers.py, where its Python has numpy and VTK), then every verb that
/// walks through the slabs of a swept mesh and of a woven one, on one thread and on all, or against
/// another build.
Result<void> measureWholeCommands(const WholeCommandsOptions& options, Report& report);

}  // namespace t4d::bench
