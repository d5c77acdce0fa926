#pragma once

#include "t4d/surface.h"

/// Solids that descriptions of robots give by their measures, about the origin.
namespace t4d::formats {

model::TriangleMesh boxMesh(const Eigen::Vector3d& size);
/// A cylinder with its axis along z. The curved side is a prism of kRoundSides sides inscribed in
/// it.
model::TriangleMesh cylinderMesh(double radius, double length);
/// A sphere of kRoundSides meridians and half as many rows of latitude, inscribed in it.
model::TriangleMesh sphereMesh(double radius);

/// A cylinder along z between two halves of a sphere; `length` is that of the cylinder alone.
model::TriangleMesh capsuleMesh(double radius, double length);

/// Surfaces are within 1 - cos(pi / kRoundSides) = 0.12 % of the radius, those of spheres 0.25 %.
inline constexpr int kRoundSides = 64;

}  // namespace t4d::formats
