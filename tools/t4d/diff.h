#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::tools {

class Members;

/// Degrees to which two files agree, the closest first.
enum class SameLevel : std::uint8_t {
  Bytes,  ///< every byte
  Mesh,   ///< bodies of the same names with the same cells, in any order and divided into any slabs
  Solid,  ///< the surfaces at each time that is compared lie within a distance
  Different,
};

struct DiffOptions {
  /// The distance, in length units, within which two surfaces are the same (Hausdorff); without it,
  /// a thousandth of the diagonal of the bounds of both meshes.
  std::optional<double> tolerance = {};
  /// How many times are compared besides the first and the last: the middles of as many equal parts
  /// of the time in which either mesh exists.
  std::uint64_t times = 16;
  std::optional<std::uint64_t> maxCells = {};  ///< as T4dReader::open takes it
};

struct Diff {
  SameLevel level = SameLevel::Different;
  /// Differences, a sentence each; also those that do not count: metadata, attributes.
  std::vector<std::string> messages;
};

/// Compares two .t4d files: their bytes, then their meshes (measure::MeshDigest), then slices of
/// the solids of all bodies together (measure::fartherThan). Reads no more than is needed for the
/// answer, with a slab or two of each in memory. Meshes of different units are different.
///
/// Fails if a file is damaged, but does not check whether a mesh is closed before it is sliced.
Result<Diff> diff(const std::filesystem::path& a, const std::filesystem::path& b,
                  const DiffOptions& options = {}, const model::Progress& progress = {});

void describe(Members& members, const Diff& diff);

}  // namespace t4d::tools
