#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "t4d/weave.h"
#include "tools/t4d/flat_caps.h"
#include "tools/t4d/lost_parts.h"
#include "tools/t4d/motion_frames.h"
#include "tools/t4d/sweep_parts.h"

namespace t4d::tools {
namespace {

Result<SweepReport> sweepMesh(const SweepOptions& options, const model::TriangleMesh& mesh,
                              const model::Motion& motion, model::Sink& sink, Observer& observer) {
  const auto stage = observer.stage("sweeping");
  const auto done = mesh4d::sweep(mesh, motion, meshMethodOf(options), sink, stage->callback());
  if (!done) return done.error();
  SweepReport report;
  report.vertices = done->vertices;
  report.tetrahedra = done->tetrahedra;
  report.steps = done->steps;
  report.capTetrahedra = done->capTetrahedra;
  report.chordBound = done->chordBound;
  report.notices = done->notices;
  return report;
}

Result<SweepReport> sweepVoxels(const VoxelMethod& how, const model::TriangleMesh& mesh,
                                const model::Motion& motion, const std::string& motionFile,
                                model::Sink& sink, Observer& observer) {
  std::vector<std::string> notices;
  auto times = motionFrameTimes(how.times, how.voxelSize, mesh, motion, motionFile, notices);
  if (!times) return times.error();
  if (!how.ignored.empty()) {
    notices.push_back(fmt::format("voxel4d ignores {}", fmt::join(how.ignored, ", ")));
  }
  auto report =
      sweepByVoxels(how, voxel4d::movingSolid(mesh, motion), std::move(*times), sink, observer);
  if (report) report->notices.insert(report->notices.begin(), notices.begin(), notices.end());
  return report;
}

/// Adds what one of several bodies became.
void addSwept(const std::string& name, const SweepReport& body, SweepReport& all) {
  all.vertices += body.vertices;
  all.tetrahedra += body.tetrahedra;
  all.steps += body.steps;
  for (const int end : {0, 1}) all.capTetrahedra[end] += body.capTetrahedra[end];
  if (body.chordBound) all.chordBound = std::max(all.chordBound.value_or(0), *body.chordBound);
  for (const std::string& notice : body.notices) {
    all.notices.push_back(fmt::format("body '{}': {}", name, notice));
  }
  all.bodies.push_back({name, body.vertices, body.tetrahedra, body.steps});
}

}  // namespace

Result<SweepReport> sweepByVoxels(const VoxelMethod& how, voxel4d::SolidAtTime solid,
                                  std::vector<double> times, model::Sink& sink,
                                  Observer& observer) {
  SweepReport report;
  const auto frames =
      voxel4d::voxelFrames(std::move(solid), std::move(times), {how.voxelSize, how.mask});
  const auto stage = observer.stage("voxelising and weaving", frames->frameCount(), "frames");
  voxel4d::WeaveOptions weaving;
  weaving.caps = how.caps;
  weaving.between = how.between;
  const auto woven = voxel4d::weave(*frames, weaving, sink, stage->callback());
  if (!woven) return woven.error();
  noticeFlatCaps(how.caps, *woven, report.notices);
  noticeLostParts(woven->partsLost, report.notices);
  report.vertices = woven->vertices;
  report.tetrahedra = woven->tetrahedra;
  report.steps = woven->frames - 1;
  report.capTetrahedra = woven->capTetrahedra;
  return report;
}

Result<SweepReport> sweepByMotion(const SweepOptions& options, const SweepInput& input,
                                  T4dFile& file, Observer& observer) {
  const auto& what = std::get<MotionSweep>(options.what);
  const auto& [solids, motion] = std::get<SolidsInMotion>(input.moving);
  SweepReport all;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    file.setBody(i);
    const formats::NamedMesh& solid = solids[i];
    auto done = what.voxels
                    ? sweepVoxels(*what.voxels, solid.mesh, motion, what.motion, file, observer)
                    : sweepMesh(options, solid.mesh, motion, file, observer);
    if (!done) {
      // Errors about the mesh or the motion do not name its file.
      Error error = done.error();
      if (!error.where.empty()) return error;
      if (error.remedy == Remedy::Motion || error.remedy == Remedy::StepRule) {
        error.where = what.motion;
        return error;
      }
      const auto placeOf = [&](const formats::NamedMesh& body) {
        return placeIn(what.solid, what.bodies ? fmt::format("body '{}'", body.name) : "");
      };
      error.where = placeOf(solid);
      for (std::size_t k = i + 1; !what.voxels && k < solids.size(); ++k) {
        auto other = faultOf(solids[k].mesh, options, placeOf(solids[k]));
        if (other) error.others.push_back(std::move(*other));
      }
      return error;
    }
    if (!what.bodies) return done;
    addSwept(solid.name, *done, all);
  }
  return all;
}

}  // namespace t4d::tools
