#pragma once

#include <CLI/CLI.hpp>

namespace t4d::tools {

/// Adds `--threads` and `--quiet` to a verb, or to those below it. They take effect before the verb
/// runs.
void addCommonOptions(CLI::App& command);

}  // namespace t4d::tools
