#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/convert/flipbook.h"
#include "t4d/formats/gltf_writer.h"
#include "t4d/formats/t4d/reader.h"

namespace t4d::tools {

/// Opens a .t4d and picks the bodies to work on.
struct InputBodies {
  formats::T4dReader reader;
  std::vector<model::Body> bodies;
};

/// All bodies, or the one of the name given; a name that is not there is an error that lists them.
Result<InputBodies> openBodies(const std::string& path, const std::string& bodyName);

/// Adds `--body`.
void addBodyOption(CLI::App& command, std::string& bodyName);

/// How a solid of this file stands in glTF: its length unit in metres and its up axis. A unit that
/// is not known adds a notice and counts as a metre.
formats::GltfPlacement placementOf(const formats::Metadata& metadata,
                                   std::vector<std::string>& notices);

}  // namespace t4d::tools
