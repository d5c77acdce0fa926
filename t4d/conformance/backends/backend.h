#pragma once

#include <memory>
#include <string>
#include <vector>

#include "t4d/conformance/backends/case.h"
#include "t4d/conformance/backends/laws.h"
#include "t4d/model/slab.h"

namespace t4d::conformance {

/// Something that makes a 4D mesh of a moving solid. To have one's own judged, implement this and
/// hand it to `runCase`.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual bool supports(const Case& given) const = 0;

  /// Coarse to fine; one without voxels where there is nothing to refine.
  virtual std::vector<Resolution> resolutions(const Case& given) const {
    (void)given;
    return {{}};
  }
  /// What the mesh must be.
  virtual Result<Law> law(const Case& given, const Resolution& resolution) const = 0;
  /// Makes the mesh.
  virtual Result<void> build(const Case& given, const Resolution& resolution,
                             model::Sink& sink) const = 0;
};

/// t4d's own, by sweeping triangles. Ends are closed by TetGen, or by cones in a build without it.
std::unique_ptr<Backend> meshBackend();

/// t4d's own, by weaving voxels: level sets of a moving mesh, or samples of a field.
std::unique_ptr<Backend> voxelBackend();

}  // namespace t4d::conformance
