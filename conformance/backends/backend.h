#pragma once

#include <string>
#include <vector>

#include "conformance/backends/case.h"
#include "conformance/backends/expectations.h"
#include "model/slab.h"

namespace t4d::conformance {

/// Makes 4D meshes of moving solids. To test your own backend, implement this interface and pass it
/// to `runCase`.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual bool supports(const Case& given) const = 0;

  /// The resolutions to test, coarse to fine; a single default one if the backend has nothing to
  /// refine.
  virtual std::vector<Resolution> resolutions(const Case& given) const {
    (void)given;
    return {{}};
  }
  /// The closed form for the mesh, with tolerances.
  virtual Result<Expectation> expectation(const Case& given,
                                          const Resolution& resolution) const = 0;
  /// Builds the mesh.
  virtual Result<void> build(const Case& given, const Resolution& resolution,
                             model::Sink& sink) const = 0;
};

}  // namespace t4d::conformance
