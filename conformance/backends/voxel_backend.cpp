#include "conformance/backends/own_backends.h"
#include "t4d/weave.h"
#include "voxel4d/frame_spacing.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::conformance {
namespace {

class VoxelBackend : public Backend {
 public:
  std::string name() const override { return "voxel4d"; }
  bool supports(const Case& given) const override { return !given.voxels.voxelSizes.empty(); }
  std::vector<Resolution> resolutions(const Case& given) const override {
    return voxelResolutions(given);
  }
  Result<Expectation> expectation(const Case& given, const Resolution& resolution) const override {
    return given.voxels.mask ? maskExpectation(given) : voxelExpectation(given, resolution);
  }
  Result<void> build(const Case& given, const Resolution& resolution,
                     model::Sink& sink) const override {
    voxel4d::FrameTimes when{resolution.steps + 1, {}};
    if (given.voxels.mask) when.step = 1;
    auto times = voxel4d::frameTimes(given.time(), when);
    if (!times) return times.error();
    const auto frames =
        given.mesh
            ? voxel4d::voxelFrames(voxel4d::movingSolid(given.mesh->mesh, given.mesh->motion),
                                   std::move(*times), {resolution.voxelSize, given.voxels.mask})
            : voxel4d::sampledFrames(
                  given.field->value, {resolution.voxelSize, model::Point3::Zero()},
                  given.field->box, std::move(*times),
                  {.slope = given.field->slope, .mask = given.voxels.maskMotion > 0});
    const auto woven = voxel4d::weave(*frames, {}, sink);
    if (!woven) return woven.error();
    return {};
  }
};

}  // namespace

std::unique_ptr<Backend> voxelBackend() { return std::make_unique<VoxelBackend>(); }

}  // namespace t4d::conformance
