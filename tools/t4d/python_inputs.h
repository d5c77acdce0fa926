#pragma once

#include <optional>
#include <span>
#include <string>

namespace t4d::tools {

inline constexpr const char* kPythonWeave = "python3 -m t4d weave";

/// What `python3 -m t4d weave` reads and the program does not: "DICOM", "Zarr", ..., by the name,
/// or by what a folder holds, or by the first bytes of a file without an extension; "" for anything
/// else.
std::string pythonInput(const std::string& path);

/// A word that is such a file.
struct PythonInput {
  std::string file;
  std::string kind;
};

/// The first such file among the words of `t4d weave`, but for its output; none beside `-`.
std::optional<PythonInput> firstPythonInput(std::span<const std::string> words);

}  // namespace t4d::tools
