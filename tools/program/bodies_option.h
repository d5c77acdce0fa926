#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "t4d/formats/triangle/mesh_bodies.h"

namespace t4d::tools {

/// Adds `--bodies`.
void addBodiesOption(CLI::App& command, std::string& bodies);

/// Its value; nothing for "".
std::optional<formats::BodiesBy> bodiesBy(const std::string& bodies);

}  // namespace t4d::tools
