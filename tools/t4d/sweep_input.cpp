#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/animation/mesh_steps.h"
#include "formats/gltf/gltf_writer.h"
#include "formats/input_file.h"
#include "formats/t4d/names.h"
#include "tools/t4d/mechanism_input.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/mesh_frames.h"
#include "tools/t4d/moving_mesh.h"
#include "tools/t4d/sweep_parts.h"

namespace t4d::tools {
namespace {

void addPaths(const std::vector<std::filesystem::path>& paths, std::vector<std::string>& files) {
  for (const auto& path : paths) files.push_back(path.string());
}

Result<SweepInput> readMoving(const MotionSweep& what, const SweepOptions& options,
                              Observer& observer) {
  auto read = readMovingMesh(
      {{what.solid, what.bodies, options.mending, !what.voxels}, what.motion, what.table},
      observer);
  if (!read) return read.error();
  LoadedSolid& solid = read->solid;
  SweepInput input;
  if (what.bodies) {
    for (formats::NamedMesh& body : solid.bodies) {
      body.name = formats::asName(body.name);
      input.infos.push_back({body.name});
    }
    input.bodyWord = *what.bodies == formats::BodiesBy::Group ? "groups" : "objects";
  }
  input.halfTurns = read->motion.halfTurns;
  input.lengthUnit = read->motion.lengthUnit;
  input.timeUnit = read->motion.timeUnit;
  input.losses = std::move(solid.losses);
  input.files = std::move(read->files);
  input.mended = std::move(solid.mended);
  input.materials = std::move(solid.materials);
  input.moving = SolidsInMotion{std::move(solid.bodies), std::move(read->motion)};
  return input;
}

Result<formats::LoadedDeformation> readDeformation(const DeformationSweep& what) {
  if (formats::isPointCache(what.files.back())) {
    return formats::readCachedMesh(what.files.front(), what.files.back(), what.times);
  }
  const std::vector<std::filesystem::path> paths(what.files.begin(), what.files.end());
  auto series = formats::readMeshSeries(paths, what.times);
  if (series && !series->timed && !what.times.between && !what.times.step) {
    series->solid.notices.emplace_back(kMeshesAreOneApart);
  }
  return series;
}

Result<SweepInput> readMoving(const DeformationSweep& what, const SweepOptions& options,
                              Observer& observer) {
  auto read = readDeformation(what);
  if (!read) return read.error();
  observer.noteEach(read->solid.notices);
  SweepInput input;
  input.losses = std::move(read->solid.losses);
  input.materials = std::move(read->solid.materials);
  input.files = what.files;
  addPaths(read->solid.otherFiles, input.files);
  addPaths(read->files, input.files);
  formats::AnimatedBody body{"", std::move(read->solid.mesh), {}};
  body.runs.push_back(std::move(read->keys));
  BodiesWithKeys moving;
  moving.bodies.push_back(std::move(body));
  moving.keyFiles = std::move(read->files);
  input.moving = std::move(moving);
  if (auto made = makeSolids(options, input, observer); !made) return made.error();
  return input;
}

Result<SweepInput> readMoving(const AnimationSweep& what, const SweepOptions& options,
                              Observer& observer) {
  formats::GltfAnimationOptions how{what.animation, what.scene, what.tolerance};
  if (options.prism == mesh4d::PrismSplit::Three) how.edgeFactor = model::kEdgeFactorOf3;
  auto file = formats::readInputFile(what.file);
  if (!file) return file.error();
  SweepInput input;
  auto read = formats::readGltfAnimation(*file, how);
  if (!read) return read.error();
  observer.noteEach(read->notices);
  for (const auto& body : read->bodies) input.infos.push_back({body.name});
  input.bodyWord = "nodes";
  input.halfTurns = std::move(read->halfTurns);
  input.losses.insert(input.losses.end(), read->losses.begin(), read->losses.end());
  input.otherAnimations = std::move(read->otherAnimations);
  input.files = {what.file};
  addPaths(read->otherFiles, input.files);
  input.materials = std::move(read->materials);
  input.lengthUnit = read->lengthUnit;
  input.timeUnit = "s";
  input.up = read->up;
  BodiesWithKeys moving;
  moving.bodies = std::move(read->bodies);
  input.moving = std::move(moving);
  if (auto made = makeSolids(options, input, observer); !made) return made.error();
  return input;
}

/// Says which bodies were mended, or became their hulls, though nobody asked for it.
void addUnasked(SweepInput& input, bool hulls) {
  std::vector<std::string> names;
  for (const auto& [name, report] : input.mended) {
    if (isReshaped(report) && isHull(report) == hulls) names.push_back(name);
  }
  if (names.empty()) return;
  input.losses.push_back(fmt::format(
      "the shape of bodies that {}: {}",
      hulls ? "became convex hulls (--hull)" : "were mended (--mend)", fmt::join(names, ", ")));
}

Result<SweepInput> readMoving(const MechanismSweep& what, const SweepOptions& options,
                              Observer& observer) {
  MechanismInput mechanism{what.file, what.motion, what.geometry, what.steps, options.prism};
  mechanism.ownSteps = what.ownSteps;
  mechanism.mending = options.mending.value_or(edit::MendSurfaceOptions());
  mechanism.hull = what.hull.value_or(Hull::Fallback);
  mechanism.maxSteps = what.maxSteps;
  mechanism.packages = what.packages;
  auto read = readMechanismBodies(mechanism, observer);
  if (!read) return read.error();
  SweepInput input;
  input.infos = std::move(read->infos);
  input.bodyWord = "solids of the mechanism";
  input.chordBound = read->chordBound;
  input.mended = std::move(read->mended);
  input.files = std::move(read->files);
  input.losses = read->mechanism->losses;
  input.losses.insert(input.losses.end(), read->losses.begin(), read->losses.end());
  for (std::string& loss : lossesOf(input.mended)) input.losses.push_back(std::move(loss));
  if (!options.mending) addUnasked(input, false);
  if (!what.hull) addUnasked(input, true);
  input.halfTurns = read->mechanism->halfTurns;
  input.joints = read->mechanism->joints;
  input.lengthUnit = read->mechanism->lengthUnit;
  input.timeUnit = read->mechanism->timeUnit;
  input.up = read->mechanism->up;
  if (auto notice = model::noticeOfHalfTurns(input.halfTurns); !notice.empty()) {
    observer.note(notice);
  }
  input.moving = BodiesWithKeys{read->mechanism, std::move(read->bodies), {}};
  return input;
}

}  // namespace

SweepKind sweepKindOf(std::span<const std::string> files, const std::string& motion) {
  const std::string& first = files.front();
  if (isMechanism(first)) return SweepKind::Mechanism;
  if (!motion.empty()) return SweepKind::Motion;
  return formats::isGltf(first) && files.size() == 1 ? SweepKind::Animation
                                                     : SweepKind::Deformation;
}

const std::string& modelOf(const SweepOptions& options) {
  if (const auto* what = std::get_if<MotionSweep>(&options.what)) return what->solid;
  if (const auto* what = std::get_if<DeformationSweep>(&options.what)) return what->files.front();
  if (const auto* what = std::get_if<AnimationSweep>(&options.what)) return what->file;
  return std::get<MechanismSweep>(options.what).file;
}

std::vector<std::string> namedFilesOf(const SweepOptions& options) {
  if (const auto* what = std::get_if<DeformationSweep>(&options.what)) return what->files;
  std::vector<std::string> files = {modelOf(options)};
  if (const auto* what = std::get_if<MotionSweep>(&options.what)) files.push_back(what->motion);
  if (const auto* what = std::get_if<MechanismSweep>(&options.what);
      what && !what->motion.empty()) {
    files.push_back(what->motion);
  }
  return files;
}

Result<SweepInput> readSweepInput(const SweepOptions& options, Observer& observer) {
  return std::visit([&](const auto& what) { return readMoving(what, options, observer); },
                    options.what);
}

}  // namespace t4d::tools
