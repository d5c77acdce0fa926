#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "t4d/formats/t4d/writer.h"

namespace t4d::tools {

/// The last component of a path, also of "frames/" and ".".
std::filesystem::path nameIn(const std::string& path);

/// The options of every verb that writes a .t4d.
struct T4dOutput {
  std::string path;
  std::string precision = "float64";
  int compression = 3;
  std::string up = "y";
  std::string body;

  void addTo(CLI::App& command);

  /// Creates a writer with one body, named by `--body` or after `model`. `detailsJson` describes
  /// how the file was made and is stored in it.
  Result<formats::T4dWriter> create(const std::string& backend, const std::string& model,
                                    const std::string& lengthUnit, const std::string& timeUnit,
                                    const std::string& detailsJson) const;
};

}  // namespace t4d::tools
