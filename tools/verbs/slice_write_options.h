#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::verbs {

/// The look and the format of slices, for sliceMesh, flipbook and frames.
struct SliceWriteOptions {
  /// Normals to write; without them, viewers shade flat.
  std::optional<formats::NormalStyle> normals = {};
  /// What triangles are coloured by; "" for no colours.
  /// * body: the colour of the body in the file, or else one of a palette;
  /// * time: from dark blue at the first time of the mesh to yellow at the last;
  /// * speed: from 0 to the largest speed of a vertex;
  /// * triangle: the attribute of that name, the triangles of a swept solid, in distinct colours;
  /// * track: the component that it belongs to (verbs::track), in distinct colours;
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

/// Fails (Options) for values that these options cannot have, a limit of speeds where none are
/// needed, and an encoding of glTF for a file that is none; `output` is "" for no file.
Result<void> checkSliceWriteOptions(const SliceWriteOptions& options,
                                    const std::filesystem::path& output);

}  // namespace t4d::verbs
