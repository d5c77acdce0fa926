#pragma once

#include <optional>

#include <CLI/CLI.hpp>

#include "t4d/edit.h"

namespace t4d::tools {

/// The limits of mending, as options of a verb.
struct MendingOptions {
  edit::MendSurfaceOptions limits;

  /// Adds `--weld`, `--max-hole`, `--thicken`, `--max-move` and `--remesh`.
  void addTo(CLI::App& command);
  /// Adds `--mend` as well, and lets the others need it.
  void addTo(CLI::App& command, bool& mend);
  /// The limits if `mend` is given.
  std::optional<edit::MendSurfaceOptions> given(bool mend) const;
};

}  // namespace t4d::tools
