#include "tools/bench/tracked_meshes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "fixtures/splash.h"
#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::bench {
namespace {

Result<model::Mesh> wovenSplash() {
  constexpr std::size_t kFrames = 60;
  constexpr double kFrameTime = 0.1;
  constexpr double kVoxelSize = 0.55;
  const std::vector<fixtures::Splash> frames = fixtures::Splash::frames(kFrames, kFrameTime);
  model::Bounds3 box;
  for (const fixtures::Splash& frame : frames) {
    for (const fixtures::Splash::Drop& drop : frame.drops) {
      const auto reach = model::Point3::Constant(fixtures::Splash::kRadius);
      box.add(drop.position - reach);
      box.add(drop.position + reach);
    }
  }
  const auto field = [&](const model::Point3& point, double time) {
    const auto number = static_cast<std::size_t>(std::llround(time / kFrameTime));
    return frames[std::min(number, kFrames - 1)].distance(point);
  };
  const auto source =
      voxel4d::sampledFrames(field, {kVoxelSize, model::Point3::Zero()}, box,
                             model::steppedTimes(0, kFrameTime, kFrames), {.slope = 1});
  model::Mesh mesh;
  if (auto woven = voxel4d::weave(*source, {}, mesh); !woven) return woven.error();
  return mesh;
}

Result<void> timeTracks(const std::string& name, const model::Mesh& mesh, Report& report) {
  std::vector<double> seconds;
  std::size_t events = 0;
  for (const std::size_t threads : {1, 2}) {
    const model::ThreadLimit limit(threads);
    std::vector<double> each;
    for (int i = 0; i < report.repetitions; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      const auto tracks = measure::tracksOf(mesh);
      if (!tracks) return tracks.error();
      each.push_back(
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
      events = tracks->events.size();
    }
    seconds.push_back(medianOf(std::move(each)));
  }
  std::uint64_t cells = 0;
  for (const model::Slab& slab : mesh.slabs()) cells += slab.connectivity->cells.size();
  report.rows.push_back({"track " + name + ", 1 thread", seconds[0], "2 threads", seconds[1]});
  report.figures.push_back({"cells of " + name, static_cast<double>(cells) / 1e6, "million"});
  report.figures.push_back({"events", static_cast<double>(events), ""});
  return {};
}

}  // namespace

Result<void> measureTrackedMeshes(const model::TriangleMesh& solid, const model::Motion& motion,
                                  double minVolumeRatio, Report& report) {
  model::Mesh swept;
  const auto made = mesh4d::sweep(
      solid, motion,
      {.steps = mesh4d::MinVolumeRatio{minVolumeRatio}, .caps = mesh4d::CapMethod::Cone}, swept);
  if (!made) return made.error();
  if (auto timed = timeTracks("a swept solid", swept, report); !timed) return timed;
  const auto splash = wovenSplash();
  if (!splash) return splash.error();
  return timeTracks("a woven splash", *splash, report);
}

}  // namespace t4d::bench
