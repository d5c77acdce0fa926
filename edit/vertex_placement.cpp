#include "edit/vertex_placement.h"

#include <cmath>

#include <Eigen/Cholesky>

namespace t4d::edit {
namespace {

/// The shorter of edges that change the shape as little goes first.
constexpr double kLengthCost = 1e-6;

/// Normals that cancel to less than this part of the star leave no direction to move in.
constexpr double kCancelled = 1e-9;

/// The place of least x'Ax + 2b'x with normal . x = flux in so many dimensions.
template <int Dimension>
std::optional<Eigen::Matrix<double, Dimension, 1>> constrainedMinimum(
    const Eigen::Matrix<double, Dimension, Dimension>& a,
    const Eigen::Matrix<double, Dimension, 1>& b, const Eigen::Matrix<double, Dimension, 1>& normal,
    double flux, double starArea, double length) {
  const Eigen::LLT<Eigen::Matrix<double, Dimension, Dimension>> solver(a);
  const Eigen::Matrix<double, Dimension, 1> least = solver.solve(-b);
  const double missing = flux - normal.dot(least);
  if (normal.norm() <= kCancelled * starArea) {
    // Nothing that the place decides; the hypervolume must be kept as it is.
    if (std::abs(flux) > kCancelled * kCancelled * starArea * length) return std::nullopt;
    return least;
  }
  const Eigen::Matrix<double, Dimension, 1> along = solver.solve(normal);
  return least + missing / normal.dot(along) * along;
}

}  // namespace

std::optional<VertexPlacement> placeVertex(const EdgeCollapse& collapse, const Pull& pull) {
  const Quadric4& quadric = collapse.quadric;
  const double trace = quadric.a.trace();
  const double strength = trace > 0 ? pull.strength * trace : 1;
  const Eigen::Matrix4d a = quadric.a + strength * Eigen::Matrix4d::Identity();
  const Eigen::Vector4d b = quadric.b - strength * pull.fraction * collapse.edge;
  const double length = collapse.edge.norm();
  VertexPlacement found;
  if (collapse.time) {
    const double t = *collapse.time;
    const auto place =
        constrainedMinimum<3>(a.topLeftCorner<3, 3>(), b.head<3>() + t * a.topRightCorner<3, 1>(),
                              collapse.normal.head<3>(), collapse.flux - collapse.normal[3] * t,
                              collapse.starArea, length);
    if (!place) return std::nullopt;
    found.place << *place, t;
  } else {
    const auto place =
        constrainedMinimum<4>(a, b, collapse.normal, collapse.flux, collapse.starArea, length);
    if (!place) return std::nullopt;
    found.place = *place;
  }
  found.cost = std::max(quadric.at(found.place), 0.0) + kLengthCost * trace * length * length;
  return found;
}

}  // namespace t4d::edit
