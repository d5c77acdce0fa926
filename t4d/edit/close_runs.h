#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/model/slab.h"

namespace t4d::edit {

/// A layer at which a run of slabs began or ended and the mesh was open.
struct RunEnd {
  std::uint64_t slab = 0;  ///< of those given, the one that has the layer
  double time = 0;
  bool begin = false;           ///< the run begins here; otherwise it ends here
  std::uint64_t triangles = 0;  ///< facets closed, each by a cell of the cap
  /// Why they could not be closed; the mesh stays open here.
  std::optional<std::string> open;
};

/// Makes a closed mesh of some of the slabs of a closed mesh. It takes them in time order and gives
/// them on; where slabs are missing, it ends the run before and begins the next with a slab without
/// thickness, the cone over the facets that the missing slab shared:
///
///                       apexes
///      *-----*-----*    /  |  \     the cap: each open facet of the layer joined to an apex at
///       \  .   .  /    *---*---*    the same time, one for each connected part of them
///
/// Open facets of a mesh closed elsewhere are a closed surface, the slice at that time, so the cone
/// closes it. It encloses nothing: hypervolume and slices of the slabs given stay exact. Between an
/// end and the next begin the mesh is empty. As with any cone, cells may overlap within the cap.
///
/// Slabs hang together where the upper layer of one equals the lower layer of the next (-0 equals
/// 0). A cell of a cap has the attributes of the cell whose facet it closes, but for "kind" and
/// "triangle" (t4d/formats/t4d/SPEC.md, section "Registries"); an apex those of a vertex of its
/// surface.
class RunCloser : public model::Sink {
 public:
  /// `sink` lives as long as this.
  explicit RunCloser(model::Sink& sink) : sink_(sink) {}

  Result<void> put(const model::Slab& slab) override;

  /// Ends the last run. Returns where runs began and ended openly, in time order.
  Result<std::vector<RunEnd>> finish();

 private:
  Result<void> beginRun(const model::Slab& slab);
  Result<void> endRun(bool another);
  Result<void> putCap(const model::Slab& neighbour, bool begin, bool needed);

  model::Sink& sink_;
  std::optional<model::Slab> last_;
  std::uint64_t count_ = 0;  // of slabs given
  std::vector<RunEnd> ends_;
};

}  // namespace t4d::edit
