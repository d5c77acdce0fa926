#pragma once

#include <Eigen/Core>

#include "t4d/mesh.h"

namespace t4d::edit {

/// A sum of squared distances from hyperplanes in R^4, each with a weight, as a function of the
/// offset x from a vertex: x'Ax + 2b'x + c (Garland and Heckbert 1997, one dimension up). Being
/// relative to the vertex, it loses no digits far from the origin.
struct Quadric4 {
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  double c = 0;
  double weight = 0;  ///< of all hyperplanes

  /// Adds a hyperplane through the vertex; `normal` has length 1.
  void addHyperplane(const Eigen::Vector4d& normal, double itsWeight) {
    a += itsWeight * normal * normal.transpose();
    weight += itsWeight;
  }

  double at(const Eigen::Vector4d& x) const { return x.dot(a * x) + 2 * b.dot(x) + c; }

  /// The quadric relative to another point, whose offset from this one is `to`.
  Quadric4 about(const Eigen::Vector4d& to) const { return {a, b + a * to, at(to), weight}; }

  Quadric4& operator+=(const Quadric4& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    weight += other.weight;
    return *this;
  }
};

}  // namespace t4d::edit
