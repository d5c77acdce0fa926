#include "conformance/backends/milling.h"
#include "conformance/backends/own_backends.h"
#include "mill/mill.h"
#include "t4d/mesh.h"

namespace t4d::conformance {
namespace {

/// The tolerance of tools: below the error of the lattice, and of the same order.
double toolTolerance(const Resolution& resolution) {
  return resolution.voxelSize * resolution.voxelSize / 200;
}

class MillBackend : public Backend {
 public:
  std::string name() const override { return "mill"; }
  bool supports(const Case& given) const override { return given.milling != nullptr; }
  std::vector<Resolution> resolutions(const Case& given) const override {
    return voxelResolutions(given);
  }
  Result<Expectation> expectation(const Case& given, const Resolution& resolution) const override {
    return voxelExpectation(given, resolution);
  }
  Result<void> build(const Case& given, const Resolution& resolution,
                     model::Sink& sink) const override {
    const Milling& milling = *given.milling;
    auto mesh = toolMesh(milling.tool, toolTolerance(resolution));
    if (!mesh) return mesh.error();
    mill::Tool tool{.mesh = std::move(*mesh)};
    for (model::Point3& vertex : tool.mesh.vertices) vertex += milling.start;
    mill::MillOptions options;
    options.voxelSize = resolution.voxelSize;
    options.times = model::evenTimes(given.time(), resolution.steps + 1);
    options.tolerance = toolTolerance(resolution);
    const auto milled = mill::mill(milling.stock, {&tool, 1}, milling.motion, options, sink);
    if (!milled) return milled.error();
    return {};
  }
};

}  // namespace

std::unique_ptr<Backend> millBackend() { return std::make_unique<MillBackend>(); }

}  // namespace t4d::conformance
