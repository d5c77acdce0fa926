#pragma once

#include <optional>

#include "edit/quadric4.h"

namespace t4d::edit {

/// The data for placing the vertex that an edge collapses to. Positions are offsets from the end a.
struct EdgeCollapse {
  Quadric4 quadric;                 ///< sum of those of both ends
  Eigen::Vector4d edge;             ///< from a to b
  Eigen::Vector4d normal;           ///< the sum of model::cellNormal over all cells around a or b
  double flux = 0;                  ///< the sum over the cells around b only, times the edge
  double starArea = 0;              ///< the magnitude of the summands of `normal`
  std::optional<double> time = {};  ///< the component t that the position must have
};

struct VertexPlacement {
  Eigen::Vector4d place;
  double cost = 0;  ///< the value of the quadric, and a little for the length of the edge
};

/// A pull towards a point of the edge, for positions that the quadric does not determine.
struct Pull {
  double fraction = 0.5;   ///< of the way from a to b
  double strength = 1e-6;  ///< relative to the quadric
};

/// The position with the smallest value of the quadric among those that keep the enclosed
/// hypervolume. Only cells around a and b change, and seen from a, those around a span no
/// hypervolume. So if the cells are joined to x, the hypervolume is kept exactly if
///
///     normal . x = flux
///
/// which is linear (Lindstrom and Turk 1998, one dimension up). Where the quadric does not
/// determine the position, as in a flat part, the pull does. Nothing if no position within reach
/// keeps the hypervolume.
std::optional<VertexPlacement> placeVertex(const EdgeCollapse& collapse, const Pull& pull = {});

}  // namespace t4d::edit
