#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// The connected components of the slices of a slab, followed from one time to another: the Reeb
/// graph of t on its cells.
///
///        t
///        ^   o           instant 2, the upper layer
///        |   |  arc 2
///        |   o           instant 1: a node where two surfaces merge
///        |  / \          arcs 0 and 1
///        | o   o         instant 0, the lower layer
///
/// Its instants are the first and the last time, and those times between at which the topology of a
/// slice changes: those of vertices of which the lower or the upper link is not one piece
/// (Edelsbrunner, Harer, Natarajan and Pascucci, 2003); vertices of one time that edges connect are
/// taken for one. All vertices of an instant belong together: a node is a component of the slice at
/// its instant, whatever happens in it. An arc is a component of the slices between two nodes.
/// Interior nodes with one arc below, one above and the same Euler number on both sides are left
/// out.
///
/// It depends on the connectivity and the order of the times alone, so slabs may share it.
struct SlabReeb {
  struct Node {
    std::uint32_t instant = 0;
    /// Twice the Euler number of the slice after the instant, less that before it, as far as it
    /// comes from this slab's cells.
    std::int64_t eulerChange2 = 0;
    /// For an interior node: the vertices where the topology changes.
    std::vector<std::uint32_t> vertices = {};
  };
  struct Arc {
    std::uint32_t below = 0;  ///< node
    std::uint32_t above = 0;
  };
  /// A cell of an arc during some slots, for those that no vertex leads to.
  struct Stretch {
    std::uint32_t arc = 0;
    std::uint32_t firstSlot = 0;
    std::uint32_t lastSlot = 0;
    std::uint32_t cell = 0;
  };

  /// A vertex at each instant between the first and the last one.
  std::vector<std::uint32_t> between;
  std::uint32_t lastInstant = 0;  ///< 0 of a slab without thickness
  std::vector<Node> nodes;
  std::vector<Arc> arcs;
  std::vector<Stretch> stretches;
  /// Instant k is slot 2k, the open interval after it slot 2k + 1.
  std::vector<std::uint32_t> slotOfVertex;
  /// The arc of each vertex between two instants, or model::kNoIndex.
  std::vector<std::uint32_t> arcOfVertex;
  /// The nodes of the vertices of the layers; model::kNoIndex for those without cells.
  std::vector<std::uint32_t> nodeOfLower;
  std::vector<std::uint32_t> nodeOfUpper;
};

/// The Reeb graph of a sound slab (checkSlab, checkConnectivity) that is closed but for its layers.
SlabReeb slabReeb(const model::Slab& slab);

/// The times of the instants.
std::vector<double> instantsOf(const SlabReeb& reeb, const model::Slab& slab);

/// The slot of the slices just after `time`, from the first instant on and before the last.
std::uint32_t slotAfter(std::span<const double> instants, double time);

}  // namespace t4d::measure
