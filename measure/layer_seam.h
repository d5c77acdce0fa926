#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/slab_topology.h"
#include "measure/transition.h"

namespace t4d::measure {

/// The components of the slice at the last layer so far, with what is known of them before the slab
/// above it.
class LayerSeam {
 public:
  /// Keeps the components at the last layer of a slab that has a duration: `transitions` of `nodes`
  /// of the last instant.
  void keep(const model::Slab& slab, const SlabReeb& reeb, std::vector<Transition> transitions,
            std::span<const std::uint32_t> nodes);

  /// Joins the components at the first time of the slab with those that are kept. Returns none of a
  /// slab without duration, after which they are kept on.
  std::vector<Transition> join(const model::Slab& slab, const SlabReeb& reeb);

  /// Gives up what is kept.
  std::vector<Transition> take();
  bool isEmpty() const { return pending_.empty(); }
  double time() const { return time_; }

 private:
  double time_ = 0;
  std::vector<Transition> pending_;
  std::vector<std::uint32_t> ofVertex_;  // of the layer, in pending_; or model::kNoIndex
};

}  // namespace t4d::measure
