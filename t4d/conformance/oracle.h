#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "t4d/measure/mesh_check.h"
#include "t4d/model/slab.h"

/// Verifies a 4D mesh against its closed form. Each check says what was expected, what was found,
/// how far apart they may be and why.
namespace t4d::conformance {

/// Whether something holds, a number of things, or a measure.
using Value = std::variant<bool, std::uint64_t, double>;

struct Check {
  std::string name;
  Value expected;
  Value actual;
  double tolerance = 0;  ///< the most by which they may differ, in their unit
  std::string reason;    ///< why so much: rounding, order of convergence, ...
  bool passed = false;
  std::string found;  ///< of a failed check: what is wrong, where more is known than the numbers
};

/// Each makes a check and says whether it is passed.
Check holds(std::string name, bool expected, bool actual, std::string reason,
            std::string found = {});
Check countIs(std::string name, std::uint64_t expected, std::uint64_t actual, std::string reason,
              std::string found = {});

/// A number, and how far from it a right answer may be.
struct Measure {
  double value = 0;
  double tolerance = 0;
  std::string reason;
};

Check measureIs(std::string name, const Measure& expected, double actual);

/// Where a surface is.
struct SurfaceExpectation {
  std::function<double(const model::Point3&)> distance;  ///< of a point; of either sign
  double tolerance = 0;  ///< the most that a vertex of the slice may be off it
  std::string reason;
};

/// What is known of the solid at a time.
struct SliceExpectation {
  double time = 0;
  std::optional<Measure> volume;
  std::optional<SurfaceExpectation> surface;
  /// The genus of each of its surfaces, in descending order; a cavity has a surface of its own.
  std::optional<std::vector<int>> genera;
};

struct Counts {
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
};

/// The box that the moving solid fills, over all times.
struct BoundsExpectation {
  model::Bounds3 box;
  double tolerance = 0;  ///< of each of the six faces, in length units
  std::string reason;
};

/// What is known of a 4D mesh.
struct Expectation {
  Measure timeBegin;
  Measure timeEnd;
  std::optional<Measure> hypervolume;
  std::optional<BoundsExpectation> bounds;
  std::vector<SliceExpectation> slices;
  std::optional<Counts> counts;
  std::optional<Counts> sideCounts;  ///< without the slabs that close the ends (no thickness)
  std::string countsReason;
  /// Inner vertices of caps have spheres for links too. A cap that is a cone over a torus, say,
  /// cannot have that; hypervolume and slices do not suffer.
  bool manifoldCaps = true;
};

struct MeshResult {
  std::vector<Check> checks;
  double hypervolume = 0;
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::vector<std::optional<double>> sliceVolumes;  ///< one for each slice of the expectation

  bool passed() const;
};

/// Checks that the mesh is valid (each slab, and the seams between them), closed, consistently
/// oriented, a manifold, and without degenerate cells; then that it is the mesh that `expectation`
/// describes. If a slab cannot be read or is invalid, that check is the last one.
///
/// Reads every slab once, and for each slice one more time.
MeshResult verify(const model::Source& mesh, const Expectation& expectation,
                  const model::Progress& progress = {});

}  // namespace t4d::conformance
