#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "formats/triangle/mesh_bodies.h"

namespace t4d::tools {

/// The value of `--bodies` that divides an animation or a deformation.
inline constexpr const char* kComponents = "component";

/// Adds `--bodies`, with kComponents where solids move by themselves.
void addBodiesOption(CLI::App& command, std::string& bodies, bool components = false);

/// The lines that divide an .obj; nothing for "" and kComponents.
std::optional<formats::BodiesBy> bodiesBy(const std::string& bodies);

}  // namespace t4d::tools
