#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

#include "t4d/error.h"
#include "t4d/file.h"
#include "t4d/surface.h"

namespace t4d::tools {
/// The look and the format of slices, for sliceMesh, flipbook and frames.
struct SliceWriteOptions {
  /// Normals to write; without them, viewers shade flat.
  std::optional<formats::NormalStyle> normals = {};
  /// What triangles are coloured by; "" for no colours.
  /// * body: the colour of the body in the file, or else one of a palette;
  /// * time: from dark blue at the first time of the mesh to yellow at the last;
  /// * speed: from 0 to the largest speed of a vertex;
  /// * triangle: the attribute of that name, the triangles of a swept solid, in distinct colours;
  /// * track: the component that it belongs to (track), in distinct colours;
  /// * attribute:NAME: an attribute, over the range of its values; three or four components are
  ///   colours themselves.
  std::string color = {};
  bool attributes = false;  ///< write attributes where the format has room for them
  /// Write the attribute `velocity` of vertices (slice::addVelocity).
  bool velocity = false;
  /// The most that a vertex may move in a time unit of the mesh, in length units; no limit without.
  std::optional<double> maxSpeed = {};
  /// Bits per coordinate in glTF, 1 to 16; float32 without.
  std::optional<std::uint64_t> quantizeBits = {};
  bool meshopt = false;  ///< as formats::GltfEncoding::meshopt
  bool center = false;   ///< write coordinates about the middle; the file says where it was

  bool isColoredBySpeed() const { return color == "speed"; }
  bool isColoredByTrack() const { return color == "track"; }
  /// Whether the colours are those of the attribute `triangle` or any other.
  bool isColoredByAttribute() const;
  /// Whether velocities are written, or needed for colours.
  bool needsVelocity() const { return velocity || isColoredBySpeed(); }
};

/// Whether SliceWriteOptions::color may be this text.
bool isSliceColor(std::string_view text);

/// Adds `--attributes`, `--normals`, `--color`, `--velocity`, `--max-speed`, `--quantize` and
/// `--meshopt`.
void addSliceWriteOptions(CLI::App& command, SliceWriteOptions& options);

/// The error message if there is a limit of speeds and nothing that it limits.
std::optional<std::string> misuseOfMaxSpeed(const SliceWriteOptions& options);

/// Why glTF cannot be encoded as asked: the file is none, or the build has no meshoptimizer.
std::optional<std::string> misuseOfEncoding(const SliceWriteOptions& options,
                                            const std::string& output);

/// A line on the colours by numbers of this range, or of an attribute; "" for others.
std::string colorText(const SliceWriteOptions& options,
                      const std::optional<std::array<double, 2>>& range);

/// A line on velocities per `unit`; "" if none are written.
std::string velocityText(const SliceWriteOptions& options, double maxSpeed, std::uint64_t clamped,
                         const std::string& unit);

/// The unit of velocities: of lengths in a second of playback or, otherwise, in a time unit.
std::string velocityUnit(const formats::Metadata& metadata, bool ofPlayback);

/// A line on how far quantized coordinates are from their places; "" if they are not quantized.
std::string quantizationText(const SliceWriteOptions& options, const std::optional<double>& error);

}  // namespace t4d::tools
