#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/formats/triangle/triangle_mesh_writer.h"

namespace t4d::tools {

/// How glTF is encoded: `--quantize` and `--meshopt`.
struct GltfOptions {
  std::optional<std::uint64_t> bits;
  bool meshopt = false;

  void addTo(CLI::App& command);

  /// Why these options cannot be: the file is no glTF, or the build has no meshoptimizer.
  std::optional<std::string> misuse(const std::filesystem::path& output) const;

  /// `bounds` are those of all vertices that are written.
  formats::GltfEncoding encoding(const model::Bounds3& bounds) const;
};

/// A line that says how far quantized coordinates are from their places; "" if they are not.
std::string quantizationText(const formats::GltfEncoding& encoding);

/// The same bound; null if they are not.
nlohmann::json quantizationError(const formats::GltfEncoding& encoding);

}  // namespace t4d::tools
