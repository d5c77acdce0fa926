#pragma once

#include <cstdint>
#include <optional>

#include <CLI/CLI.hpp>

#include "tools/verbs/input.h"

namespace t4d::tools {

/// The choice of bodies of a .t4d file.
struct InputOptions : verbs::InputOptions {
  /// Adds `--body` and `--max-cells`.
  void addTo(CLI::App& command);
};

/// Help of an argument that takes a .t4d file as T4dReader::open does.
inline constexpr const char* kT4dFileHelp =
    "Input file (.t4d, .t4dm): path or URL (http://, https://)";

/// Added where it can be a pipe, too.
inline constexpr const char* kOrPipeHelp = ", or - for standard input";

/// Adds `--max-cells`.
void addMaxCellsOption(CLI::App& command, std::optional<std::uint64_t>& maxCells);

}  // namespace t4d::tools
