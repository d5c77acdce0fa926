#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tools/t4d/input.h"

namespace t4d::tools {
/// A part of the time.
struct TimeWindow {
  std::optional<double> from = {};  ///< without it, from the first time of the mesh on
  std::optional<double> to = {};    ///< without it, up to the last

  bool isWhole() const { return !from && !to; }

  /// The span that is asked for, as far as the mesh exists; its ends are the nearest layer or end
  /// of a body where that is meant. Fails (Options) if it ends before it begins, and if the mesh
  /// does not exist then.
  Result<model::TimeSpan> spanIn(const Input& input) const;

  /// Adds `--from` and `--to`.
  void addTo(CLI::App& command);
};

/// Removes bodies that have no cell within the span, with a notice for each.
void keepThoseWithin(const model::TimeSpan& span, Input& input, std::vector<std::string>& notices);

}  // namespace t4d::tools
