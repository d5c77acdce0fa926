#include "conformance/backends/own_backends.h"
#include "t4d/sweep.h"

namespace t4d::conformance {
namespace {

#ifdef T4D_WITH_TETGEN
constexpr mesh4d::CapMethod kCaps = mesh4d::CapMethod::TetGen;
#else
constexpr mesh4d::CapMethod kCaps = mesh4d::CapMethod::Cone;
#endif

class MeshBackend : public Backend {
 public:
  std::string name() const override { return "mesh4d"; }
  bool supports(const Case& given) const override { return given.mesh.has_value(); }
  Result<Expectation> expectation(const Case& given, const Resolution&) const override {
    return sweptExpectation(given, kCaps == mesh4d::CapMethod::Cone);
  }
  Result<void> build(const Case& given, const Resolution&, model::Sink& sink) const override {
    mesh4d::SweepOptions options;
    options.steps = mesh4d::MinVolumeRatio{given.minVolumeRatio};
    options.caps = kCaps;
    const auto swept = mesh4d::sweep(given.mesh->mesh, given.mesh->motion, options, sink);
    if (!swept) return swept.error();
    return {};
  }
};

}  // namespace

std::unique_ptr<Backend> meshBackend() { return std::make_unique<MeshBackend>(); }

}  // namespace t4d::conformance
