#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/solid_difference.h"
#include "measure/surface_distance.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

/// Compares two 4D meshes by the solids they represent at given times.
namespace t4d::measure {

struct CompareOptions {
  SolidDifferenceOptions difference = {};
  double distanceTolerance = 1e-3;  ///< for surfaceDistance
};

/// Two solids at one time; a solid that does not exist then is empty.
struct SliceComparison {
  double time = 0;
  double volumeA = 0;
  double volumeB = 0;
  double areaA = 0;
  double areaB = 0;
  SolidDifference difference;
  SurfaceDistance distance;
};

/// The solid of all bodies that exist at a time, as one closed mesh without attributes; empty if
/// none does. Fails if slicing does.
Result<model::TriangleMesh> solidAt(std::span<const model::Body> bodies, double time);

/// Fails if solidDifference does.
Result<SliceComparison> compareSolids(double time, const model::TriangleMesh& a,
                                      const model::TriangleMesh& b,
                                      const CompareOptions& options = {});

/// Compares the solids at each time, one on each thread, which has two slabs and two slices in
/// memory.
Result<std::vector<SliceComparison>> compareAt(std::span<const model::Body> a,
                                               std::span<const model::Body> b,
                                               std::span<const double> times,
                                               const CompareOptions& options = {},
                                               const model::Progress& progress = {});

/// `count` times from the first to the last of `span`, as evenly spaced as goes without a beat: the
/// slices of a sweep are smallest half way between two layers, so times that fall now on a layer
/// and now between two would make a zigzag of a constant volume. Each time but the first and the
/// last is moved to the middle of the longest step of the bodies that it falls into, unless that
/// step has four times or more, which show what happens in it. Times that are then the same are
/// one, so there may be fewer.
std::vector<double> timesAmidSteps(std::span<const model::Body> bodies, const model::TimeSpan& span,
                                   std::uint64_t count);

/// How many of `times` fall within some body, and on a layer or an end of every body that exists
/// then. If all do, the comparison says nothing about the time between layers.
std::size_t timesOnLayers(std::span<const model::Body> bodies, std::span<const double> times);

}  // namespace t4d::measure
