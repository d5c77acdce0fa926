#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tools/t4d/ctc_labels.h"

namespace t4d::tools {

/// Labels of tracks for the Cell Tracking Challenge.
struct CtcOption {
  std::string folder;  ///< "" for none
  std::vector<double> spacing;
  std::vector<double> origin;
  std::vector<double> size;

  /// Adds `--ctc`, which it returns, `--spacing`, `--origin` and `--size`.
  CLI::Option* addTo(CLI::App& command);

  /// The message on a wrong combination; "" for none.
  std::string misuse() const;

  /// Writes the folder (writeCtc).
  Result<CtcReport> write(const Input& input, const TrackReport& report,
                          const std::vector<double>& times, Observer& observer) const;
};

}  // namespace t4d::tools
