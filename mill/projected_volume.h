#pragma once

#include <functional>

#include "t4d/mesh.h"

namespace t4d::mill {

/// The cells of a slab, projected along time: the integral of n_t over them.
struct ProjectedVolume {
  model::TimeSpan time;
  double exits = 0;    ///< volume of the cells with n_t > 0
  double entries = 0;  ///< the same of those with n_t < 0
};

/// Sums the projected volumes of each slab and passes it on. The boundary of a solid has the
/// integral 0, so between two layers exits less entries are what the volume has become smaller by,
/// and where there are no entries nothing has come back. Of a start cap, entries are the volume.
class ProjectedVolumes : public model::Sink {
 public:
  ProjectedVolumes(model::Sink& next, std::function<void(const ProjectedVolume&)> take)
      : next_(next), take_(std::move(take)) {}

  Result<void> put(const model::Slab& slab) override;
  /// Has the vertices of the slab in memory.
  Result<void> putStreamed(const model::StreamedSlab& slab) override;

 private:
  model::Sink& next_;
  std::function<void(const ProjectedVolume&)> take_;
};

}  // namespace t4d::mill
