#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/mesh.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct Rotation {
  std::array<double, 3> axis = {0, 0, 1};  ///< through the origin, of any length but 0
  double degrees = 0;                      ///< counter-clockwise seen from the tip of the axis
};

/// A map of space and time. It is applied in the order of the members.
struct TransformOptions {
  /// Which axis of the input becomes x, y and z, and t if there are four, each with a minus or
  /// without: "y-xz", "xtzy". "" for none.
  std::string axes = {};
  std::optional<std::array<double, 3>> scale = {};  ///< factors along x, y and z; none is 0
  std::optional<Rotation> rotate = {};
  /// 3 rows of 4 numbers, row by row, the last of each row a translation.
  std::optional<std::array<double, 12>> matrix = {};
  std::optional<std::array<double, 3>> move = {};  ///< added to all positions
  double timeScale = 1;                            ///< above 0
  double timeShift = 0;                            ///< added to the scaled times

  std::optional<std::string> lengthUnit = {};  ///< a new name; numbers do not change
  std::optional<std::string> timeUnit = {};    ///< a new name; numbers do not change
  std::optional<std::string> up = {};          ///< "y" or "z"; the solid does not change
  std::optional<std::string> space =
      {};                      ///< as formats::Metadata::space; the solid does not change
  std::string output = {};     ///< the .t4d to write
  int compression = 3;         ///< as formats::T4dWriteOptions::compression
  std::string generator = {};  ///< program and version, for the metadata
};

struct TransformReport {
  std::uint64_t bodies = 0;
  std::string axes;      ///< as TransformOptions
  model::Transform map;  ///< after axes that exchange or reverse time
  /// The anatomical space of the mesh if it is mirrored and has the same one as before.
  std::string mirroredSpace = {};
  std::uint64_t bytes = 0;
  double seconds = 0;
  std::vector<std::string> losses = {};
};

/// Whether `axes` are those of TransformOptions.
bool areAxes(const std::string& axes);

/// Moves, rotates, scales or mirrors the bodies, changes their times, and writes the file. Slabs
/// are mapped one after another (model::Transformed); where time is exchanged or reversed, all of
/// the mesh is in memory (edit::mapSpaceTime). Fails if doubles cannot keep the shape where the
/// mesh would be, or its coordinates or extents are out of range.
Result<TransformReport> transform(const Input& input, const TransformOptions& options,
                                  Observer& observer = nobody());

void describe(Members& members, const TransformReport& report);

}  // namespace t4d::tools
