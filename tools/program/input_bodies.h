#pragma once

#include <cstdint>
#include <optional>
#include <span>
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

/// Which file to open, and what of it.
struct InputOptions {
  std::vector<std::string> bodies;        ///< only the bodies of these names; none for all
  std::optional<std::uint64_t> maxCells;  ///< as T4dReader::open takes it

  /// Adds `--body` and `--max-cells`.
  void addTo(CLI::App& command);
};

/// Help of an argument that takes a .t4d file as T4dReader::open does.
inline constexpr const char* kT4dFileHelp = "Input file (.t4d): path or URL (http:// or https://)";

/// Added where it can be a pipe, too.
inline constexpr const char* kOrPipeHelp = ", or - for standard input";

/// All slabs of these bodies.
std::uint64_t slabCountOf(std::span<const model::Body> bodies);

/// Opens a .t4d file. Selects all bodies, or those named; an unknown name is an error that lists
/// the existing ones.
Result<InputBodies> openBodies(const std::string& path, const InputOptions& options);

/// The metadata of the file for another one that has only the selected bodies, made by this
/// program. A body whose parent is not among them has none.
formats::Metadata metadataOf(const InputBodies& input);

/// Adds `--max-cells`.
void addMaxCellsOption(CLI::App& command, std::optional<std::uint64_t>& maxCells);

/// The error with the name of the input as its place, unless it has one.
Error inInput(Error error, const InputBodies& input);

/// Whether the motion between two layers is the screw from the pose of the one to that of the
/// other. In a sweep of an animation, nodes may move along curves there.
bool followsPoses(const InputBodies& input);

/// Bounds in space of the selected bodies, at all times.
model::Bounds3 boundsOf(const InputBodies& input);

/// How to place a solid of this file in glTF: its length unit in metres and its up axis. An unknown
/// unit is taken as metres, with a notice.
formats::GltfPlacement placementOf(const formats::Metadata& metadata,
                                   std::vector<std::string>& notices);

}  // namespace t4d::tools
