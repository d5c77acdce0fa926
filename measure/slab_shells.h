#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "measure/level_flood.h"
#include "measure/slab_topology.h"
#include "measure/transition.h"

namespace t4d::measure {

/// The surfaces in the slab that is being worked on, and what the tracker asks of its geometry.
class SlabShells {
 public:
  SlabShells(const model::Slab& slab, const MeasuredSlab& measured);

  const model::Slab& slab() const { return slab_; }
  const std::vector<double>& instants() const { return measured_.instants; }
  const SlabReeb& reeb() const { return measured_.topology->reeb; }
  LevelFlood& flooding();

  /// Adds the surfaces above a transition to `shells`, with their Euler numbers and whether they
  /// face outward. `solids`: the shells have their solids.
  void make(Transition& transition, bool solids, std::vector<Shell>& shells);

  /// Finds for each of some cavities, just after a time, the surface that bounds its solid, too.
  std::vector<std::uint32_t> nextShells(double time, const std::vector<std::uint32_t>& inner) const;

  /// The components of the slice at some nodes, with the surfaces below that have begun.
  std::vector<Transition> transitionsAt(std::span<const std::uint32_t> nodes) const;
  /// The nodes after the first instant, in the order of time.
  std::vector<std::uint32_t> nodesInOrder() const;
  /// The arcs that reach the last layer.
  std::vector<std::uint32_t> arcsAtEnd() const;
  /// Finds the surfaces of arcsAtEnd, and for each that whose solid it bounds (itself if it faces
  /// outward; model::kNoIndex if there is none), from the slice there alone.
  std::vector<Shell> shellsAtEnd(std::vector<std::uint32_t>& owners) const;

  std::vector<std::uint32_t> shellOfArc;  ///< model::kNoIndex before it begins

 private:
  struct ArcValue {
    double time = 0;
    SolidMeasures measures;
    std::int64_t euler2 = 0;
  };

  void evaluate(const std::vector<std::uint32_t>& wanted);
  bool birthIsOuter(std::uint32_t node);
  std::vector<std::uint32_t> cellsAt(std::span<const std::uint32_t> vertices);
  bool splitLocally(const Transition& one, const std::vector<Shell>& shells,
                    std::vector<Shell>& made);

  const model::Slab& slab_;
  const MeasuredSlab& measured_;
  std::vector<std::vector<std::uint32_t>> arcsBelow_;  // each node
  std::vector<std::vector<std::uint32_t>> arcsAbove_;
  std::map<std::uint32_t, ArcValue> values_;  // of some arcs
  std::unique_ptr<LevelFlood> flood_;
};

}  // namespace t4d::measure
