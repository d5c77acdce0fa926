#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "t4d/formats/animation/key_divider.h"
#include "t4d/formats/triangle/triangle_mesh_reader.h"
#include "t4d/formats/usd/usd_scene.h"

namespace t4d::formats {

/// The vertices of a Mesh prim over time, in the coordinates of the stage. Between two samples,
/// points move straight. Numbers are read from the text when they are asked for.
class UsdShape : public MovingShape {
 public:
  enum class When : std::uint8_t { Played, AtFirst };

  /// Reads the mesh of a prim for all of the time that is played, or for its beginning alone:
  /// `mesh` becomes its triangles, facing outward, and its vertices at the first sample, before
  /// they are moved. Fails if the faces change, if a sample has another number of points or numbers
  /// that are not finite, or if points that are one vertex come apart.
  static Result<std::shared_ptr<const UsdShape>> read(const UsdScene& scene,
                                                      const UsdPlacedMesh& placed, When when,
                                                      LoadedMesh& mesh);

  /// Points have samples.
  bool deforms() const { return samples_.size() > 1; }
  /// The times of all samples that move it.
  std::vector<double> times() const;

  void place(double time, bool atEnd, std::span<model::Point3> into) const override;
  std::optional<Eigen::Affine3d> pose(double time, bool /*atEnd*/) const override {
    return deforms() ? std::nullopt : std::optional(placed_.world(time));
  }
  double accelerationBound(double begin, double end) const override;

 private:
  using Points = std::vector<model::Point3>;
  struct Sample {
    double time = 0;
    std::string_view text;
  };

  UsdShape(std::shared_ptr<const UsdDocument> document, std::shared_ptr<const UsdLayer> layer,
           UsdPlacedMesh placed)
      : document_(std::move(document)), layer_(std::move(layer)), placed_(std::move(placed)) {}

  Result<LoadedMesh> readFaces(const UsdScene& scene, When when);
  Result<Points> filePoints(std::string_view text) const;
  Result<Points> vertices(std::string_view text) const;
  /// The vertices at a sample, which has been checked.
  std::shared_ptr<const Points> at(std::size_t sample) const;
  Points pointsAt(double time) const;

  std::shared_ptr<const UsdDocument> document_;
  std::shared_ptr<const UsdLayer> layer_;  // which the placed mesh refers to
  UsdPlacedMesh placed_;
  std::string_view type_;  // of the points
  std::vector<Sample> samples_;
  FilePoints file_;
  std::size_t vertexCount_ = 0;
  mutable std::mutex mutex_;
  mutable std::array<std::pair<std::size_t, std::shared_ptr<const Points>>, 2> kept_;
};

}  // namespace t4d::formats
