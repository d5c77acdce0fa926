#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "t4d/formats/t4d/writer.h"

namespace t4d::tools {

/// The name of a file or folder in the folder above it, also of "frames/" and ".".
std::filesystem::path nameIn(const std::string& path);

/// The options of every verb that writes a .t4d, and what they lead to.
struct T4dOutput {
  std::string path;
  std::string precision = "float64";
  int compression = 3;
  std::string up = "y";
  std::string body;

  void addTo(CLI::App& command);

  /// A writer with one body, named after `model` unless `--body` says otherwise. `detailsJson` is
  /// what the file remembers of how it was made.
  Result<formats::T4dWriter> create(const std::string& backend, const std::string& model,
                                    const std::string& lengthUnit, const std::string& timeUnit,
                                    const std::string& detailsJson) const;
};

}  // namespace t4d::tools
