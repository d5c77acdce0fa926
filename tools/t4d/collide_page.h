#pragma once

#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/surface.h"

namespace t4d::tools {

/// A pair of bodies on the page.
struct CollidePair {
  std::string a;
  std::string b;
  std::string verdict;            ///< a sentence
  std::vector<double> times;      ///< none for bodies that never exist together
  std::vector<double> clearance;  ///< at each time; 0 for solids in contact
  std::vector<double> overlaps;   ///< volume of the overlap at each time; none without contact
  /// Both solids at first contact or, without one, when they are nearest.
  double time = 0;
  model::TriangleMesh solidA;
  model::TriangleMesh solidB;
  /// Triangles in contact, one flag each.
  std::vector<bool> contactA;
  std::vector<bool> contactB;
};

/// One self-contained HTML page: for each pair the verdict, plots of clearance and overlap over
/// time, and pictures.
std::string collidePage(const std::string& title, const formats::Metadata& metadata,
                        const std::vector<CollidePair>& pairs);

}  // namespace t4d::tools
