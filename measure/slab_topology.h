#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "measure/level_surfaces.h"
#include "measure/slab_reeb.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

namespace t4d::measure {

/// The data that slabs with the same connectivity and the same order of times share.
struct SlabTopology {
  std::shared_ptr<const model::Connectivity> connectivity;
  std::vector<std::uint8_t> ranks;  ///< of the times of interior vertices
  SlabReeb reeb;
  /// The slice just after the lower layer, without triangles that are flat there.
  LevelSurfaces atLower;
  std::vector<std::uint32_t> arcsAtLower;
};

/// The surfaces of a slice, by arcs of the slab.
struct ArcMeasures {
  double time = 0;
  std::vector<std::pair<std::uint32_t, SolidMeasures>> ofArcs = {};
};

/// The data that the tracker gets from a slab alone, without earlier ones.
struct MeasuredSlab : model::Sink::Prepared {
  Result<void> sound;
  std::shared_ptr<const SlabTopology> topology;
  std::vector<double> instants;
  std::vector<ArcMeasures> samples;
};

/// Measures slabs, several at once. Those that share a connectivity share their topology.
class SlabTopologies {
 public:
  /// The times of samples, increasing, and the last time of the mesh.
  SlabTopologies(std::vector<double> sampleTimes, double end)
      : times_(std::move(sampleTimes)), end_(end) {}

  /// Measures a slab, with samples at its times, unless not `sampled`.
  std::unique_ptr<MeasuredSlab> measured(const model::Slab& slab, bool sampled = true) const;
  bool isSampled(double time) const;

 private:
  std::shared_ptr<const SlabTopology> shared(const model::Slab& slab) const;
  std::shared_ptr<const SlabTopology> made(const model::Slab& slab) const;

  std::vector<double> times_;
  double end_;
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const SlabTopology>> shared_;
};

}  // namespace t4d::measure
