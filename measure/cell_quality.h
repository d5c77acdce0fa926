#pragma once

#include <array>

#include "model/geometry.h"

namespace t4d::measure {

/// The shape of a tetrahedron in R^4, measured within its own three dimensions. The best
/// tetrahedron is the regular one; what each measure is of it stands in brackets. A flat cell has
/// infinite ratios, angles of 0 and 180 degrees and no height.
struct CellQuality {
  double volume = 0;         ///< 3-measure, in length^3
  double edgeRatio = 0;      ///< longest edge divided by the shortest [1]
  double radiusRatio = 0;    ///< radius of the circumsphere, divided by three inradii [1]
  double smallestAngle = 0;  ///< between two sides, in degrees [70.53]
  double largestAngle = 0;   ///< between two sides, in degrees [70.53]
  double height = 0;         ///< the smallest height, divided by the longest edge [0.8165]
};

/// Measures a tetrahedron after its times have been multiplied by `timeScale`, a length for each
/// unit of time.
CellQuality qualityOf(const std::array<model::Point4, 4>& corners, double timeScale);

}  // namespace t4d::measure
