#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/check.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct QualityOptions {
  /// A length for each unit of time; without it, the mean normal speed of the surface, or the
  /// size divided by the duration if nothing moves.
  std::optional<double> timeScale = {};
  std::uint64_t worst = 10;  ///< how many cells to name
  /// The share of the slabs of each body that is measured. The time scale is that of all of them.
  model::Part part = {};
  /// A .t4d to write: the mesh with measures as attributes of its cells; "" for none.
  std::string output = {};
  std::vector<std::string> attributes = {};  ///< names of those measures; none for radius_ratio
  int compression = 3;                       ///< as formats::T4dWriteOptions::compression
  std::string generator = {};                ///< program and version, for the metadata of `output`
};

struct QualityReport {
  measure::MeshQuality quality;
  std::string scaleReason;                  ///< where the time scale is from
  std::vector<std::string> bodies;          ///< names, by the numbers in `quality`
  std::optional<std::uint64_t> bytes = {};  ///< of `output`
  std::vector<std::string> losses = {};     ///< as formats::T4dWriter::losses
};

/// Measures the shape of all cells (measure::measureQuality), slab by slab, and writes `output`.
/// A time scale with which all cells would be flat up to rounding is an error (Options).
Result<QualityReport> quality(const Input& input, const QualityOptions& options = {},
                              Observer& observer = nobody());

/// The data of a part that `t4d join` needs, as JSON: the distributions, without rounding.
std::string partStateOf(const QualityReport& report);

void describe(Members& members, const QualityReport& report);

}  // namespace t4d::tools
