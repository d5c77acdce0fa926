// Tests a backend against closed-form solutions: here a sweep whose ends are closed by cones.
#include <cstdio>

#include <t4d/conformance.h>
#include <t4d/sweep.h>

using namespace t4d;

class OwnBackend : public conformance::Backend {
 public:
  std::string name() const override { return "own"; }
  bool supports(const conformance::Case& given) const override { return given.mesh.has_value(); }

  /// The mesh must match the true solid within 1 %.
  Result<conformance::Expectation> expectation(const conformance::Case& given,
                                               const conformance::Resolution&) const override {
    return conformance::solidExpectation(given, 0.01);
  }

  /// Puts the slabs into the sink. Your own backend would build them here.
  Result<void> build(const conformance::Case& given, const conformance::Resolution&,
                     model::Sink& sink) const override {
    mesh4d::SweepOptions options;
    options.steps = mesh4d::MinVolumeRatio{given.minVolumeRatio};
    options.caps = mesh4d::CapMethod::Cone;
    const auto swept = mesh4d::sweep(given.mesh->mesh, given.mesh->motion, options, sink);
    return swept ? Result<void>() : swept.error();
  }
};

int main() {
  const OwnBackend backend;
  for (const conformance::Case& given : conformance::analyticCases()) {
    if (given.large || !backend.supports(given)) continue;
    const auto result = conformance::runCase(given, backend, true);
    std::printf("%s %s: %zu of %zu checks passed\n", result.passed() ? "PASS" : "FAIL",
                result.id.c_str(), result.passedChecks(), result.checks.size());
  }
}
