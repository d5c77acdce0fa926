#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "measure/mesh_check.h"
#include "model/slab.h"

/// Verifies a 4D mesh against its closed form. Each check states the expected and the actual value,
/// the tolerance, and the reason for it.
namespace t4d::conformance {

/// A property, a count, or a measure.
using Value = std::variant<bool, std::uint64_t, double>;

struct Check {
  std::string name;
  Value expected;
  Value actual;
  double tolerance = 0;  ///< the maximum difference, in the unit of the values
  std::string reason;    ///< why the tolerance is what it is: rounding, order of convergence, ...
  bool passed = false;
  std::string found;  ///< for a failed check: what is wrong, if more is known than the numbers
};

/// Each of these functions returns a check with `passed` set.
Check holds(std::string name, bool expected, bool actual, std::string reason,
            std::string found = {});
Check countIs(std::string name, std::uint64_t expected, std::uint64_t actual, std::string reason,
              std::string found = {});

/// A number and its tolerance.
struct Measure {
  double value = 0;
  double tolerance = 0;
  std::string reason;
};

Check measureIs(std::string name, const Measure& expected, double actual);

/// Location of a surface.
struct SurfaceExpectation {
  std::function<double(const model::Point3&)> distance;  ///< from a point; of either sign
  double tolerance = 0;  ///< the maximum distance of a vertex of the slice
  std::string reason;
};

/// Expected properties of the solid at one time.
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
  double tolerance = 0;  ///< for each of the six faces, in length units
  std::string reason;
};

/// When the solid first touches another one.
struct ContactExpectation {
  std::shared_ptr<const model::Source> obstacle;
  Measure time;
  /// Whether the mesh can be moved out of the way of the obstacle with edit::resolve.
  bool canGiveWay = false;
};

/// Expected properties of a 4D mesh.
struct Expectation {
  Measure timeBegin;
  Measure timeEnd;
  std::optional<Measure> hypervolume;
  std::optional<BoundsExpectation> bounds;
  /// The integral over space of the number of visits to each point (measure::Silhouette).
  std::optional<Measure> visitsVolume;
  /// measure::meanNormalSpeed, the time scale of the quality of cells.
  std::optional<Measure> meanNormalSpeed;
  std::optional<ContactExpectation> contact;
  std::vector<SliceExpectation> slices;
  std::optional<Counts> counts;
  std::optional<Counts> sideCounts;  ///< without the slabs that close the ends (no thickness)
  std::string countsReason;
  /// The links of inner cap vertices are spheres too. A cone over a torus, for example, cannot
  /// satisfy this; hypervolume and slices are not affected.
  bool manifoldCaps = true;
};

struct MeshResult {
  std::vector<Check> checks;
  double hypervolume = 0;
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::vector<std::optional<double>> sliceVolumes;  ///< one per slice of the expectation

  bool passed() const;
};

/// Checks that the mesh is valid (each slab, and the seams between them), closed, consistently
/// oriented, a manifold, and without degenerate cells; then that it matches `expectation`. If a
/// slab cannot be read or is invalid, that check is the last one.
///
/// Reads every slab once, and once more for each slice and each of the other properties.
MeshResult verify(const model::Source& mesh, const Expectation& expectation,
                  const model::Progress& progress = {});

}  // namespace t4d::conformance
