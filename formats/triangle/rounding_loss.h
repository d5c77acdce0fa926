#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// The effect of rounding coordinates on a shape: how much of its surface becomes flat or turns
/// over.
class RoundingLoss {
 public:
  /// Rounding to multiples of `step`, or to float32.
  explicit RoundingLoss(std::optional<double> step = {}) : step_(step) {}
  /// Rounding to double, by moving a mesh far from the origin.
  static RoundingLoss ofMoving() {
    RoundingLoss loss;
    loss.moved_ = true;
    return loss;
  }

  void add(const model::TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& rounded);
  void add(const model::Slab& slab, const model::Slab& rounded);

  /// A line for the user; nothing if less than a millionth of the whole and less than a thousandth
  /// of each connected part is lost, for a 4D mesh of each part of a slab. Slivers get lost in any
  /// rounding.
  std::optional<std::string> line() const;

 private:
  /// A connected part of the mesh, or of one slab of it.
  struct Part {
    double measure = 0;
    double lost = 0;
  };
  void add(double measure, bool kept, Part& part);
  void addParts(const std::vector<Part>& parts);

  std::optional<double> step_;
  std::array<double, 2> unit_ = {};  // factors for lengths and times, once they are known
  bool moved_ = false;
  const char* elements_ = "triangles";
  std::uint64_t elementCount_ = 0;
  std::uint64_t lostCount_ = 0;
  Part all_;
  bool partLost_ = false;
  double farthest_ = 0;  // the largest coordinate
};

}  // namespace t4d::formats
