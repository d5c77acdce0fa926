#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Vertices whose places are a smooth function of time between keys.
class MovingShape {
 public:
  virtual ~MovingShape() = default;

  /// The places at a time; `atEnd`: as the end of what is before it, where they jump.
  virtual void place(double time, bool atEnd, std::span<model::Point3> into) const = 0;
  /// The map that moves all vertices from where they are in the shape; nothing if they move apart.
  virtual std::optional<Eigen::Affine3d> pose(double time, bool atEnd) const = 0;
  /// A bound of the second derivative of every vertex's place over an interval without keys inside.
  virtual double accelerationBound(double begin, double end) const = 0;
};

/// Divides the time between the keys of a body so that slices are within a tolerance of it. This
/// is proved, not sampled: of a function with a second derivative of at most a, the chord over a
/// time h is at most h^2 a / 8 away, and model::edgeDeviation bounds what slices are off their
/// vertices.
class KeyDivider {
 public:
  struct Limits {
    double tolerance = 0;
    double edgeFactor = 0;  ///< of model::edgeDeviation
  };

  /// `where` is that of errors.
  KeyDivider(const MovingShape& shape, const model::TriangleMesh& mesh, const Limits& limits,
             Place where)
      : shape_(shape),
        triangles_(mesh.triangles),
        limits_(limits),
        where_(std::move(where)),
        from_(mesh.vertices.size()),
        to_(mesh.vertices.size()) {}

  /// Adds the ends of steps within a span between two keys. Fails for more than an hour of 55 a
  /// second, and where the shape turns too fast for the tolerance.
  Result<void> divide(const model::TimeSpan& span, std::vector<double>& times);

 private:
  double edgesOff(const model::TimeSpan& span, std::uint64_t count);
  Error tooManyKeys() const;

  const MovingShape& shape_;
  std::span<const model::Triangle> triangles_;
  Limits limits_;
  Place where_;
  std::vector<model::Point3> from_;
  std::vector<model::Point3> to_;
  std::size_t keys_ = 0;
};

/// The largest extent of a shape along an axis, at the first, the middle and the last time.
double largestExtent(const MovingShape& shape, std::size_t vertexCount,
                     const model::TimeSpan& played);

/// The tolerance of each shape: the one that is given, or a thousandth of its own extent, and at
/// least a billionth of the largest one, which dust would need too many keys for. Fails if there is
/// no positive length; `where` is that of the error.
Result<std::vector<double>> tolerancesOf(const std::optional<double>& given,
                                         std::span<const double> extents, Place where);

}  // namespace t4d::formats
