#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/check.h"
#include "t4d/edit.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct SimplifyOptions {
  /// The part of the cells to keep, above 0 and at most 1.
  std::optional<double> ratio = {};
  /// The number of cells to keep, of all bodies together. Not with a ratio.
  std::optional<std::uint64_t> cells = {};
  /// The bound edit::SimplifyOptions::maxError. Without any of the three, a thousandth of the
  /// diagonal of the bounds of each body.
  std::optional<double> maxError = {};
  std::optional<double> timeScale = {};  ///< as timeScaleOf takes it
  std::string preserve = {};             ///< as edit::SimplifyOptions::preserve
  std::optional<std::uint64_t> windowSlabs = {};
  model::Part part = {};       ///< as edit::SimplifyOptions::part, of each body
  std::uint64_t times = 17;    ///< at which slices are compared, evenly spaced
  std::size_t pairs = 0;       ///< slices to keep in the report
  std::string output = {};     ///< the .t4d to write
  int compression = 3;         ///< as formats::T4dWriteOptions::compression
  std::string generator = {};  ///< program and version, for the metadata
};

/// Slices of the input and of the result.
struct SliceDistance {
  double time = 0;
  double distance = 0;  ///< Hausdorff
};
struct SlicePair {
  double time = 0;
  model::TriangleMesh before;
  model::TriangleMesh after;
};

struct SimplifyReport {
  edit::SimplifyReport mesh;  ///< of all bodies together
  std::string scaleReason;    ///< where the time scale is from
  double measuredError = 0;   ///< the largest distance of two slices at one time (Hausdorff)
  double measuredErrorTime = 0;
  double meanError = 0;  ///< the mean of these distances
  std::vector<SliceDistance> distances = {};
  std::vector<SlicePair> pairs = {};                 ///< the first and the last, and some between
  std::array<measure::MeshQuality, 2> quality = {};  ///< before and after
  std::uint64_t bytesBefore = 0;                     ///< of the file; 0 for a mesh in memory
  std::uint64_t bytes = 0;
  double seconds = 0;  ///< of the simplification alone, with reading and writing
  std::vector<std::string> losses = {};

  /// `height` of the cells before (0) and after (1), of which simplification keeps the least.
  measure::Distribution heights(std::size_t which) const;
};

/// Simplifies each body (edit::simplify) and writes the file; then reads it again, compares slices
/// of both at times, and measures the shape of the cells of both. Fails (Options) for an error that
/// no mesh can meet.
Result<SimplifyReport> simplify(const Input& input, const SimplifyOptions& options,
                                Observer& observer = nobody());

void describe(Members& members, const SimplifyReport& report);

}  // namespace t4d::tools
