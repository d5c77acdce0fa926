#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/convert/flipbook.h"
#include "t4d/formats/gltf_writer.h"
#include "t4d/formats/t4d/reader.h"

namespace t4d::tools {

/// An open .t4d file and the bodies selected from it.
struct InputBodies {
  formats::T4dReader reader;
  std::vector<model::Body> bodies;
};

/// Opens a .t4d file. Selects all bodies, or the one named; an unknown name is an error that lists
/// the existing ones.
Result<InputBodies> openBodies(const std::string& path, const std::string& bodyName);

/// Bounds in space of the selected bodies, at all times.
model::Bounds3 boundsOf(const InputBodies& input);

/// Adds `--body`.
void addBodyOption(CLI::App& command, std::string& bodyName);

/// How to place a solid of this file in glTF: its length unit in metres and its up axis. An unknown
/// unit is taken as metres, with a notice.
formats::GltfPlacement placementOf(const formats::Metadata& metadata,
                                   std::vector<std::string>& notices);

}  // namespace t4d::tools
