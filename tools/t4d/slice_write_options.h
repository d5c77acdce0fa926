#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "t4d/file.h"
#include "tools/verbs/slice_write_options.h"

namespace t4d::tools {

/// Adds `--attributes`, `--normals`, `--color`, `--velocity`, `--max-speed`, `--quantize` and
/// `--meshopt`.
void addSliceWriteOptions(CLI::App& command, verbs::SliceWriteOptions& options);

/// The error message if there is a limit of speeds and nothing that it limits.
std::optional<std::string> misuseOfMaxSpeed(const verbs::SliceWriteOptions& options);

/// Why glTF cannot be encoded as asked: the file is none, or the build has no meshoptimizer.
std::optional<std::string> misuseOfEncoding(const verbs::SliceWriteOptions& options,
                                            const std::string& output);

/// A line on the colours by numbers of this range, or of an attribute; "" for others.
std::string colorText(const verbs::SliceWriteOptions& options,
                      const std::optional<std::array<double, 2>>& range);

/// A line on velocities per `unit`; "" if none are written.
std::string velocityText(const verbs::SliceWriteOptions& options, double maxSpeed,
                         std::uint64_t clamped, const std::string& unit);

/// The unit of velocities: of lengths in a second of playback or, otherwise, in a time unit.
std::string velocityUnit(const formats::Metadata& metadata, bool ofPlayback);

/// A line on how far quantized coordinates are from their places; "" if they are not quantized.
std::string quantizationText(const verbs::SliceWriteOptions& options,
                             const std::optional<double>& error);

}  // namespace t4d::tools
