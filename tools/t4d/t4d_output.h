#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "tools/t4d/t4d_file.h"

namespace t4d::tools {

/// Adds `-o`, the .t4d file to write, or one with one of these extensions.
void addT4dOutputOption(CLI::App& command, std::string& path,
                        std::vector<std::string_view> others = {});

/// Adds `--compression`.
void addCompressionOption(CLI::App& command, int& level);

/// The coding of a .t4d file.
struct T4dCoding {
  std::string precision = "float64";
  std::optional<double> grid;
  int compression = 3;
  std::uint64_t spareEvery = 0;

  void addTo(CLI::App& command);
  formats::T4dWriteOptions writeOptions() const;
  /// A line about positions that are rounded, for the report of what was written; or nothing.
  std::optional<std::string> rounding() const;
};

/// The options of every verb that makes a .t4d from something else.
struct T4dOutput {
  std::string path;
  T4dCoding coding;
  std::string up;  ///< "y" or "z"; "" if it is not given
  std::string body;
  bool center = false;

  void addTo(CLI::App& command, std::vector<std::string_view> others = {});
  T4dFileOptions fileOptions() const;
};

}  // namespace t4d::tools
