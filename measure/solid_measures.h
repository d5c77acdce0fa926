#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/body.h"
#include "model/triangle_mesh.h"

namespace t4d::measure {

/// What a solid at one time is, in length units; exact but for rounding. Of nothing, all is 0.
struct SolidMeasures {
  double time = 0;
  double volume = 0;
  double area = 0;
  model::Point3 centroid = model::Point3::Zero();
  std::uint64_t components = 0;  ///< connected surfaces that face outward
  std::uint64_t cavities = 0;    ///< those that face inward
  /// Sum of those of all surfaces (generaOf): the number of handles.
  double genus = 0;
  model::Bounds3 bounds = {};  ///< empty() of nothing

  /// Adds another solid at the same time, which counts as apart from this one.
  void add(const SolidMeasures& other);
};

/// Of a closed triangle mesh that faces outward; `time` is 0.
SolidMeasures measuresOf(const model::TriangleMesh& mesh);

/// Each body at each of `times`, which may be in any order; that of nothing when it does not exist.
/// Several times are sliced at once, one on each thread, which has a slab in memory. Fails for a
/// time before the first body or after the last, and if slicing does.
Result<std::vector<std::vector<SolidMeasures>>> measuresOfEach(
    std::span<const model::Body> bodies, std::span<const double> times,
    const model::Progress& progress = {});

/// The solids of several bodies at the same times as one (SolidMeasures::add).
std::vector<SolidMeasures> addedUp(std::span<const std::vector<SolidMeasures>> bodies);

/// Both: the solid of all bodies that exist at each of `times`.
Result<std::vector<SolidMeasures>> measuresAt(std::span<const model::Body> bodies,
                                              std::span<const double> times,
                                              const model::Progress& progress = {});

}  // namespace t4d::measure
