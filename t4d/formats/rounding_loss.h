#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::formats {

/// What rounding coordinates to float32 does to a shape: how much of its surface becomes flat or
/// turns over.
class RoundingLoss {
 public:
  void add(const model::TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& rounded);
  void add(const model::Slab& slab);

  /// A line for the user; nothing if less than a millionth of the surface is lost. Slivers get lost
  /// in any rounding.
  std::optional<std::string> line() const;

 private:
  void add(double measure, bool kept);

  const char* elements_ = "triangles";
  std::uint64_t elementCount_ = 0;
  std::uint64_t lostCount_ = 0;
  double measure_ = 0;
  double lostMeasure_ = 0;
  double farthest_ = 0;  // the largest coordinate
};

}  // namespace t4d::formats
