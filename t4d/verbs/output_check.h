#pragma once

#include <optional>
#include <span>
#include <string>

namespace t4d::verbs {

/// The error message if the file `output` must not be written: it is one of the inputs, under any
/// name, or a frame in a folder that is one of them.
std::optional<std::string> misuseOfOutput(const std::string& output,
                                          std::span<const std::string> inputs);

/// The error message if two of the files to write are one, under any names. "" and "-" are no
/// files.
std::optional<std::string> misuseOfOutputs(std::span<const std::string> outputs);

}  // namespace t4d::verbs
