#include "tools/t4d/motion_frames.h"

#include <fmt/format.h>

#include "model/amount_text.h"
#include "model/limits.h"
#include "t4d/weave.h"

namespace t4d::tools {

Result<std::vector<double>> motionFrameTimes(const voxel4d::FrameTimes& when, double voxelSize,
                                             const model::TriangleMesh& mesh,
                                             const model::Motion& motion,
                                             const std::string& motionFile,
                                             std::vector<std::string>& notices) {
  const auto inMotion = [&](Error error) {
    error.where = motionFile;
    return error;
  };
  const model::Bounds3 bounds = boundsOf(mesh);
  const double narrowest = (bounds.max - bounds.min).minCoeff();
  if (voxelSize > narrowest) {
    notices.push_back(fmt::format(
        "voxels of {} are larger than the solid, which is {:.4g} wide: it may fall between lattice "
        "points",
        voxelSize, narrowest));
  }
  const model::TimeSpan span{motion.timeBegin(), motion.timeEnd()};
  const double speed = voxel4d::maxSpeed(mesh, motion);
  const auto enough = voxel4d::framesWithin(voxelSize, speed, span);
  if (!when.count && !when.step) {
    if (enough) return voxel4d::frameTimes(span, {*enough, {}}).map_error(inMotion);
    Error error = enough.error();
    error.message += "; use larger voxels, or choose the number of frames";
    return inMotion(std::move(error));
  }
  auto times = voxel4d::frameTimes(span, when);
  if (!times) return inMotion(times.error());
  for (std::size_t i = 1; i < times->size(); ++i) {
    const double apart = (*times)[i] - (*times)[i - 1];
    if (apart >= model::kSmallestExtent) continue;
    return invalid(fmt::format("frames would be {:.3g} apart in time; at least {} is possible",
                               apart, model::kSmallestExtent),
                   motionFile);
  }
  const std::string gaps = noticeOfGaps(*times, speed, voxelSize, enough);
  if (!gaps.empty()) notices.push_back(gaps);
  return times;
}

std::string noticeOfGaps(std::span<const double> times, double speed, double voxelSize,
                         const Result<std::uint64_t>& enough) {
  const double voxels = voxel4d::largestGap(times) * speed / voxelSize;
  constexpr double kRounding = 1e-9;
  if (!(voxels > 1 + kRounding)) return {};
  return fmt::format(
      "points move up to {:.3g} voxels between two frames; {} over the whole motion would keep "
      "them within one",
      voxels,
      enough ? model::counted(*enough, "frame")
             : fmt::format("more than {} frames", model::grouped(voxel4d::kMaxFrames)));
}

}  // namespace t4d::tools
