#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tools/program/input_bodies.h"

namespace t4d::tools {

/// A part of the time: `--from` and `--to`.
struct TimeWindow {
  std::optional<double> from;
  std::optional<double> to;

  void addTo(CLI::App& command);

  /// Why these options cannot be.
  std::optional<std::string> misuse() const;

  bool isWhole() const { return !from && !to; }

  /// The span that is asked for, as far as the mesh exists; its ends are the nearest layer or end
  /// of a body where that is meant. Fails if the mesh does not exist then.
  Result<model::TimeSpan> spanIn(const InputBodies& input) const;
};

/// Removes bodies that have no cell within the span, with a notice for each.
void keepThoseWithin(const model::TimeSpan& span, InputBodies& input,
                     std::vector<std::string>& notices);

}  // namespace t4d::tools
