#pragma once

#include <memory>
#include <string>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::convert {

/// Takes all slabs of a body that keeps its triangles: every slab with a thickness consists of
/// prisms (prisms.h) of the same triangles, and there are no gaps in time. Fails for other bodies,
/// with the time and the reason.
class PrismSteps : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override;

 protected:
  /// Takes a slab with a thickness; triangles() is set.
  virtual Result<void> step(const model::Slab& slab) = 0;

  /// The triangles, in vertices of the lower layer or, equally, of the upper one.
  const std::vector<model::Triangle>& triangles() const { return triangles_; }

  /// The error "at time ..., WHY".
  static Error no(double time, const std::string& why);

 private:
  Result<void> checkTriangles(const model::Slab& slab);

  std::vector<model::Triangle> triangles_;
  std::shared_ptr<const model::Connectivity> connectivity_;
  double end_ = 0;  // of the last step
};

/// An error of PrismSteps with the name of the body added, and the way in which it cannot be shown.
Error ofBody(const std::string& body, const std::string& isNot, Error error);

}  // namespace t4d::convert
