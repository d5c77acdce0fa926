#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "edit/displaced_source.h"

namespace t4d::edit {

/// A displacement that a vertex of a layer needs.
struct Push {
  double depth = 0;                             ///< at least this far
  model::Point3 along = model::Point3::Zero();  ///< approximate direction; of length 1
};
using LayerPushes = std::map<std::uint32_t, Push>;
using Pushes = std::map<LayerKey, LayerPushes>;

/// The way in which pushes spread.
struct Spread {
  double space = 0;   ///< up to this distance, positive
  double time = 0;    ///< up to this time before and after
  bool stay = false;  ///< no decrease after the time of the push
};

/// Spreads pushes over vertices nearby in space and time:
///
///   depth(v, t) = max over pushes (w, s) of depth(w, s) f(|v(s) - w(s)| / space) f((t - s) / time)
///
/// with f(x) = (1 - x^2)^2 up to 1, 0 beyond; the direction is the mean of those of the pushes,
/// with the same weights. So no push is lowered, and vertices out of reach of all pushes do not
/// move. Where the direction is constant, the displacement is a function of the position with a
/// slope of at most 1.54 depth / space. If this is below 1, no two positions coincide afterwards,
/// so a layer that did not cross itself before does not do so afterwards.
///
/// `layers` has the times of all layers, including those within steps. The result has the layers
/// that move, and all those within steps.
Result<Displacement> spread(const VertexTracks& tracks, const std::map<LayerKey, double>& layers,
                            const Pushes& pushes, const Spread& by);

/// The positions of the vertices of a layer; for a layer within a step, on their straight tracks.
Result<std::vector<model::Point3>> placesAt(const VertexTracks& tracks, const LayerKey& key);

}  // namespace t4d::edit
