#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Writes bodies that change their shapes and keep their triangles.
class ShapesWriter {
 public:
  virtual ~ShapesWriter() = default;

  /// Adds a body and its first shape. `shown`: from when on it is shown (true) or hidden, the first
  /// from 0 on; empty: always shown.
  virtual Result<void> addBody(const NamedMesh& first, double time,
                               std::span<const std::pair<double, bool>> shown) = 0;

  /// Adds the shape of the last body at a later time: the same triangles, as many vertices.
  virtual Result<void> addShape(const NamedMesh& shape, double time) = 0;

  /// Writes the file, which plays up to `end`; returns what was lost, as writeTriangleMeshes.
  /// Without `finish` no file appears.
  virtual Result<std::vector<std::string>> finish(double end) = 0;
};

}  // namespace t4d::formats
