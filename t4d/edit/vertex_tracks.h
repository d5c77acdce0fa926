#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::edit {

/// A body that keeps its triangles, as sweeps make it: vertex i is the same point of the surface in
/// every layer, and all other vertices of slabs are means of those of layers. Caps are at its first
/// and its last time only.
class VertexTracks {
 public:
  /// Reads the source once. Fails for a body that is not such a one, saying at which time and why.
  /// `source` must outlive this object.
  static Result<VertexTracks> of(const model::Source& source, const model::Progress& progress = {});

  const model::Source& source() const { return *source_; }
  /// Of vertices of a layer, facing outward.
  const std::vector<model::Triangle>& triangles() const { return triangles_; }
  std::size_t vertexCount() const { return vertexCount_; }

  /// The slabs that last are those from `firstStep` on, so many.
  std::size_t firstStep() const { return firstStep_; }
  std::size_t steps() const { return steps_; }
  /// Of the layer below a step; for `step` = steps(), the last layer.
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
