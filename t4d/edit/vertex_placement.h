#pragma once

#include <optional>

#include "t4d/edit/quadric4.h"

namespace t4d::edit {

/// What decides where the vertex goes that an edge collapses to; places are offsets from the end a.
struct EdgeCollapse {
  Quadric4 quadric;                 ///< of both ends
  Eigen::Vector4d edge;             ///< from a to b
  Eigen::Vector4d normal;           ///< the sum of model::cellNormal over all cells around a or b
  double flux = 0;                  ///< that over the cells around b, times the edge
  double starArea = 0;              ///< a magnitude of what `normal` is the sum of
  std::optional<double> time = {};  ///< the component t that the place must have
};

struct VertexPlacement {
  Eigen::Vector4d place;
  double cost = 0;  ///< the quadric there, and a little for the length of the edge
};

/// What draws the place to a point of the edge where the quadric does not decide.
struct Pull {
  double fraction = 0.5;   ///< of the way from a to b
  double strength = 1e-6;  ///< as a part of the quadric
};

/// The place where the quadric is smallest of those that keep the enclosed hypervolume. All cells
/// that change are those around a and b, and about a those around a span nothing; so with cells
/// joined to a place x, the hypervolume is kept exactly if
///
///     normal . x = flux
///
/// which is linear (Lindstrom and Turk 1998, one dimension up). Where the quadric does not decide,
/// as in a flat part, the pull does. Nothing if no place in reach keeps
/// the hypervolume.
std::optional<VertexPlacement> placeVertex(const EdgeCollapse& collapse, const Pull& pull = {});

}  // namespace t4d::edit
