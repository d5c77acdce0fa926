#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/slab.h"

namespace t4d::edit {

/// A layer where a run of consecutive slabs begins or ends and the mesh is open.
struct RunEnd {
  std::uint64_t slab = 0;  ///< the slab with this layer, counted among those put
  double time = 0;
  bool begin = false;           ///< the run begins here; otherwise it ends here
  std::uint64_t triangles = 0;  ///< facets closed, each by one cap cell
  /// Why the facets could not be closed; the mesh stays open here.
  std::optional<std::string> open;
};

/// Turns a subset of the slabs of a closed mesh into a closed mesh. It takes slabs in time order
/// and passes them on. Where slabs are missing, it adds two slabs without thickness: one ends the
/// run before the gap, the other begins the run after it. Each is a cone over the facets that the
/// missing slab shared:
///
///                       apexes
///      *-----*-----*    /  |  \     the cap: each open facet of the layer is joined to an apex at
///       \  .   .  /    *---*---*    the same time, one apex per connected part of them
///
/// The open facets of a mesh that is closed elsewhere form a closed surface, the slice at that
/// time, so the cone closes the mesh. It encloses nothing: the hypervolume and the slices of the
/// given slabs stay exact. In the gap the mesh is empty. As with any cone, cells may overlap within
/// the cap.
///
/// Two slabs are consecutive if the upper layer of one equals the lower layer of the next (-0
/// equals 0). A cap cell has the attributes of the cell whose facet it closes, except "kind" and
/// "triangle" (formats/t4d/SPEC.md, section "Registries"). An apex has the attributes of a
/// vertex of its surface.
class RunCloser : public model::Sink {
 public:
  /// `sink` must outlive this object.
  explicit RunCloser(model::Sink& sink) : sink_(sink) {}

  Result<void> put(const model::Slab& slab) override;

  /// Ends the last run. Returns where runs began and ended with open facets, in time order.
  Result<std::vector<RunEnd>> finish();

 private:
  Result<void> beginRun(const model::Slab& slab);
  Result<void> endRun(bool another);
  Result<void> putCap(const model::Slab& neighbour, bool begin, bool needed);

  model::Sink& sink_;
  std::optional<model::Slab> last_;
  std::uint64_t count_ = 0;  // slabs put so far
  std::vector<RunEnd> ends_;
};

}  // namespace t4d::edit
