#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// A body that keeps its triangles, like those of sweeps: vertex i is the same point of the surface
/// in every layer, and all other vertices of slabs are means of those of layers. Caps are at its
/// first and its last time only.
class VertexTracks {
 public:
  /// Reads the source once. Fails if the body does not keep its triangles, with the time and the
  /// reason. `source` must outlive this object.
  static Result<VertexTracks> of(const model::Source& source, const model::Progress& progress = {});

  const model::Source& source() const { return *source_; }
  /// The triangles of every layer, facing outward.
  const std::vector<model::Triangle>& triangles() const { return triangles_; }
  std::size_t vertexCount() const { return vertexCount_; }

  /// The first slab with a duration. It and the following ones, steps() in number, are the steps.
  std::size_t firstStep() const { return firstStep_; }
  std::size_t steps() const { return steps_; }
  /// The time of the layer below a step; for `step` = steps(), of the last layer.
  double layerTime(std::size_t step) const;
  Result<std::vector<model::Point3>> layer(std::size_t step) const;

 private:
  const model::Source* source_ = nullptr;
  std::vector<model::Triangle> triangles_;
  std::size_t vertexCount_ = 0;
  std::size_t firstStep_ = 0;
  std::size_t steps_ = 0;
};

}  // namespace t4d::edit
