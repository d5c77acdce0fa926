#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace t4d::tools {

/// Adds `--center`.
void addCenterOption(CLI::App& command, bool& center);

/// reportLosses (console.h), with a hint at `--center` where float32 spoils a shape that is not
/// centered.
int reportLosses(const std::vector<std::string>& losses, bool centered);

}  // namespace t4d::tools
