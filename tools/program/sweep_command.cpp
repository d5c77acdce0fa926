#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/animation/deformation_reader.h"
#include "t4d/formats/animation/foreign_scene.h"
#include "t4d/formats/animation/mesh_steps.h"
#include "t4d/formats/file_extension.h"
#include "t4d/formats/gltf/gltf_animation.h"
#include "t4d/formats/input_file.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/formats/usd/usd_animation.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/verbs/lost_parts.h"
#include "t4d/verbs/motion_frames.h"
#include "t4d/verbs/t4d_file.h"
#include "t4d/voxel4d/voxelize.h"
#include "t4d/voxel4d/weave.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/mechanism_input.h"
#include "tools/program/mending.h"
#include "tools/program/mesh_frames.h"
#include "tools/program/moving_mesh.h"
#include "tools/program/numbers.h"
#include "tools/program/option_checks.h"
#include "tools/program/solid_input.h"
#include "tools/program/t4d_output.h"
#include "tools/program/voxel_series.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct SweepArguments {
  std::vector<std::string> models;
  std::string motion;  // "" for solids that are deformed
  MotionOptions table;
  bool mend = false;
  MendingOptions mending;
  std::string dividedBy;  // --bodies
  std::string keyTimes;
  formats::GltfAnimationOptions animation;
  std::string geometry;  // of a .urdf
  bool ownSteps = false;
  std::string backend = "mesh4d";
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::optional<double> maxDeviation;
  std::string caps;  // "" for the backend's default
  std::optional<int> prism;
  std::optional<model::Part> part;
  std::optional<double> voxelSize;
  voxel4d::FrameTimes times;
  bool mask = false;
  std::optional<std::string> between;
  T4dOutput output;
  bool json = false;

  bool voxels() const { return backend == "voxel4d"; }
  /// Without a motion: keys of a deformation, or of an animation.
  bool hasKeys() const { return motion.empty() || isMechanism(models.front()); }
  /// Nodes or bodies with names, of a scene or a mechanism.
  bool hasNames() const { return animates() || isMechanism(models.front()); }
  bool animates() const {
    const std::string extension = formats::lowerCaseExtension(models.front());
    return motion.empty() && models.size() == 1 &&
           (extension == ".gltf" || extension == ".glb" ||
            formats::isForeignScene(models.front()) || formats::isAnimatedUsd(models.front()));
  }
};

/// The result of either backend.
struct Made {
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t steps = 0;
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};
  std::vector<std::string> notices;
  std::optional<double> chordBound = {};       // where a motion was swept
  std::optional<ordered_json> folds = {};      // where keys were swept
  std::optional<ordered_json> crossings = {};  // likewise; null if not searched for
  std::optional<ordered_json> bodies = {};     // of an animation
};

/// The error message if options do not fit a mechanism.
std::optional<std::string> misuseOfMechanism(const SweepArguments& options) {
  if (options.models.size() > 1) return "a mechanism is given alone: it names its solids";
  const bool urdf = isUrdf(options.models.front());
  if (urdf && options.motion.empty()) {
    return "--motion is required for a .urdf: a table of its joints over time (docs/mechanism.md)";
  }
  if (!urdf && !options.motion.empty()) {
    return "--motion is not for a mechanism, which names its motions itself";
  }
  if (!urdf && !options.geometry.empty()) return "--geometry is for a .urdf";
  if (!options.dividedBy.empty()) return "--bodies is not for a mechanism: each body is one";
  if (!options.table.table.empty()) {
    return "--angles, --quaternion, --length-unit and --time-unit are not for a mechanism, which "
           "names its units";
  }
  if (options.part) return "--part is not for a mechanism";
  if (options.voxels()) return "--backend voxel4d is not for a mechanism";
  if (!options.keyTimes.empty() || options.times.step) {
    return "--times and --frame-time are not for a mechanism";
  }
  if (!options.animation.animation.empty() || !options.animation.scene.empty()) {
    return "--animation and --scene are for an animated glTF";
  }
  return std::nullopt;
}

/// The same for what says how a solid moves.
std::optional<std::string> misuseOfMotion(const SweepArguments& options) {
  if (isMechanism(options.models.front())) return misuseOfMechanism(options);
  if (options.ownSteps || !options.geometry.empty()) {
    return "--own-steps and --geometry are for a mechanism (.json or .urdf)";
  }
  const bool namesPart = !options.animation.animation.empty() || !options.animation.scene.empty();
  const bool isUsd = formats::isAnimatedUsd(options.models.front());
  if (namesPart && (isUsd || !options.animates())) {
    return "--animation and --scene are for an animated glTF";
  }
  const bool collected = std::ranges::any_of(
      options.models, [](const auto& model) { return formats::isCollection(model); });
  if (collected && options.models.size() > 1) {
    return "a collection (.pvd) is given alone: it lists the meshes";
  }
  if (!options.hasKeys()) {
    if (collected || options.models.size() > 1) {
      return "--motion is for one solid; several meshes, their collection (.pvd), or a point cache "
             "move by themselves";
    }
    if (!options.keyTimes.empty()) return "--times is for a solid that is deformed";
    return std::nullopt;
  }
  if (!options.dividedBy.empty()) return "--bodies is for --motion";
  if (!options.table.table.empty()) {
    return "--angles, --quaternion, --length-unit and --time-unit are for --motion";
  }
  if (options.mend && options.animates()) return "--mend is not for an animated glTF";
  if (options.mend && (options.mending.limits.remesh || options.mending.limits.maxMove)) {
    return "--remesh and --max-move are for --motion: mending a deformation moves no vertex";
  }
  if (options.voxels()) return "--backend voxel4d needs --motion";
  if (options.animates()) {
    if (options.rvMin || options.steps || !options.keyTimes.empty() || options.times.step) {
      return "--rv-min, --steps, --times and --frame-time are not for an animated glTF; "
             "--tolerance sets its steps";
    }
    if (options.part) return "--part is not for an animated glTF";
    return std::nullopt;
  }
  if (formats::lowerCaseExtension(options.models.front()) == ".bvh") {
    return "a .bvh holds the motion of a skeleton and no mesh: name a mesh, and give the poses of "
           "a "
           "joint as a table (.csv) with --motion";
  }
  if (options.models.size() < 2 && !collected) {
    return "--motion is required, but for an animated .glb, .gltf, .fbx or .dae, for a mechanism "
           "(.json) and for a solid that is deformed: name meshes of the same triangles, a "
           "collection of them (.pvd), or a "
           "mesh and its point cache (.pc2 or .mdd)";
  }
  const auto caches = std::ranges::count_if(
      options.models, [](const std::string& model) { return formats::isPointCache(model); });
  if (caches > 0 && (options.models.size() != 2 || !formats::isPointCache(options.models[1]))) {
    return "a point cache (.pc2 or .mdd) follows the one mesh that it belongs to";
  }
  if (options.rvMin || options.steps || options.maxDeviation) {
    return "--rv-min, --steps, --max-deviation and --tolerance are for --motion: a solid that is "
           "deformed goes "
           "straight from key to key";
  }
  if (!options.keyTimes.empty() && options.times.step) {
    return "--times and --frame-time exclude each other";
  }
  return std::nullopt;
}

/// The error message if the options cannot be combined; nothing if they can.
std::optional<std::string> misuseOf(const SweepArguments& options) {
  if (const auto misuse = misuseOfMotion(options)) return misuse;
  if (options.voxels()) {
    if (!options.voxelSize) return "--backend voxel4d needs --voxel-size";
    if (options.part) return "--part is for --backend mesh4d";
    return std::nullopt;
  }
  const bool frameTime = options.times.step && !options.hasKeys();
  if (options.voxelSize || options.times.count || frameTime || options.mask || options.between) {
    return "--voxel-size, --frames, --frame-time, --mask and --between are for --backend voxel4d";
  }
  if (options.part && !options.dividedBy.empty()) {
    return "--part and --bodies exclude each other";
  }
  if (options.part && options.output.center) {
    return "--part and --center exclude each other: the parts would not meet";
  }
  if (isVoxelCaps(options.caps)) {
    return "--caps " + options.caps + " is for --backend voxel4d; mesh4d has tetgen and cone";
  }
  return std::nullopt;
}

/// SweepArguments that voxel4d ignores, so that both backends accept the same arguments.
std::vector<std::string> ignoredBy(const SweepArguments& options) {
  std::vector<std::string> names;
  if (options.rvMin) names.emplace_back("--rv-min");
  if (options.steps) names.emplace_back("--steps");
  if (options.maxDeviation) names.emplace_back("--max-deviation");
  if (options.prism) names.emplace_back("--prism");
  if (!options.caps.empty() && !isVoxelCaps(options.caps)) names.emplace_back("--caps");
  return names;
}

mesh4d::StepRule ruleOf(const SweepArguments& options) {
  if (options.steps) return mesh4d::StepsPerSegment{*options.steps};
  if (options.maxDeviation) return mesh4d::MaxDeviation{*options.maxDeviation};
  return mesh4d::MinVolumeRatio{options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio)};
}

/// How the file was made, for its metadata.
std::string detailsOf(const SweepArguments& options, const std::vector<std::string>& materials) {
  ordered_json parameters;
  if (options.voxels()) {
    parameters["voxel_size"] = *options.voxelSize;
    if (options.times.count) parameters["frames"] = *options.times.count;
    if (options.times.step) parameters["frame_time"] = *options.times.step;
    parameters["mask"] = options.mask;
    if (options.mask) parameters["between"] = options.between.value_or("distance");
    parameters["caps"] = isVoxelCaps(options.caps) ? options.caps : voxelCaps().front();
  } else {
    if (options.animates()) {
      if (options.maxDeviation) parameters["tolerance"] = *options.maxDeviation;
      if (!options.animation.animation.empty()) {
        parameters["animation"] = options.animation.animation;
      }
      if (!options.animation.scene.empty()) parameters["scene"] = options.animation.scene;
    } else if (options.hasKeys() && !isMechanism(options.models.front())) {
      if (!options.keyTimes.empty()) parameters["times"] = options.keyTimes;
      if (options.times.step) parameters["frame_time"] = *options.times.step;
    } else if (options.steps) {
      parameters["steps"] = *options.steps;
    } else if (options.maxDeviation) {
      parameters["max_deviation"] = *options.maxDeviation;
    } else {
      parameters["rv_min"] = options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio);
    }
    if (options.ownSteps) parameters["own_steps"] = true;
    if (!options.geometry.empty()) parameters["geometry"] = options.geometry;
    parameters["caps"] = options.caps == "cone" ? "cone" : "tetgen";
    parameters["prism"] = options.prism.value_or(14);
  }
  parameters["precision"] = options.output.coding.precision;
  if (!options.dividedBy.empty()) parameters["bodies"] = options.dividedBy;
  if (options.output.coding.grid) parameters["grid"] = *options.output.coding.grid;
  const auto nameOf = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  const bool mechanism = isMechanism(options.models.front());
  ordered_json source{{mechanism ? "mechanism" : "mesh", nameOf(options.models.front())}};
  if (!options.motion.empty()) {
    source["motion"] = nameOf(options.motion);
  } else if (formats::isPointCache(options.models.back())) {
    source["cache"] = nameOf(options.models.back());
  } else if (!options.animates() && options.models.size() > 1) {
    source["last_mesh"] = nameOf(options.models.back());
    source["meshes"] = options.models.size();
  }
  ordered_json details{{"source", source}, {"parameters", parameters}};
  if (!materials.empty()) details["materials"] = materials;
  return details.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

mesh4d::SweepOptions meshOptions(const SweepArguments& options) {
  mesh4d::SweepOptions how;
  how.steps = ruleOf(options);
  how.caps = options.caps == "cone" ? mesh4d::CapMethod::Cone : mesh4d::CapMethod::TetGen;
  how.prism = options.prism == 3 ? mesh4d::PrismSplit::Three : mesh4d::PrismSplit::Fourteen;
  how.part = options.part.value_or(model::Part());
  return how;
}

Made madeOf(const mesh4d::SweepReport& report) {
  return {report.vertices,      report.tetrahedra, report.steps,
          report.capTetrahedra, report.notices,    report.chordBound};
}

Result<Made> sweepMesh(const SweepArguments& options, const model::TriangleMesh& mesh,
                       const model::Motion& motion, model::Sink& sink) {
  ProgressBar bar("sweeping");
  const auto report = mesh4d::sweep(mesh, motion, meshOptions(options), sink, bar.callback());
  if (!report) return report.error();
  return madeOf(*report);
}

/// What was found of one kind in the steps of all bodies, as JSON.
class FoundInSteps {
 public:
  /// `place` has the members that the kinds do not share.
  template <class Found>
  void add(const Found& found, const std::string& body, ordered_json place) {
    if (first_.size() == mesh4d::kMostFolds) return;
    ordered_json entry{{"time", {found.time.begin, found.time.end}}};
    entry.update(place);
    entry["place"] = {found.place.x(), found.place.y(), found.place.z()};
    if (!body.empty()) entry["body"] = body;
    first_.push_back(std::move(entry));
  }
  const ordered_json& first() const { return first_; }

 private:
  ordered_json first_ = ordered_json::array();
};

/// Sweeps bodies through their keys; the file has as many bodies.
Result<Made> sweepKeys(const SweepArguments& options,
                       const std::vector<formats::AnimatedBody>& bodies, verbs::T4dFile& file) {
  std::uint64_t keys = 0;
  for (const auto& body : bodies) {
    for (const auto& run : body.runs) keys += run->count();
  }
  ProgressBar bar("sweeping", keys, "keys");
  Made made;
  std::uint64_t foldedPrisms = 0;
  std::uint64_t foldedSteps = 0;
  FoundInSteps folds;
  std::uint64_t crossingPairs = 0;
  std::uint64_t crossingSteps = 0;
  std::uint64_t unfinishedSteps = 0;
  bool soughtCrossings = false;
  FoundInSteps crossings;
  ordered_json parts = ordered_json::array();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const formats::AnimatedBody& body = bodies[i];
    file.setBody(i);
    Made ofBody;
    for (const auto& run : body.runs) {
      const auto report =
          mesh4d::sweep(body.mesh, *run, meshOptions(options), file, bar.part(run->count()));
      if (!report) {
        Error error = report.error();
        if (options.hasNames() && (error.where.empty() || error.where.starts_with("key "))) {
          error.where = fmt::format("{}: body '{}'{}{}", options.models.front(), body.name,
                                    error.where.empty() ? "" : ": ", error.where);
        }
        return error;
      }
      ofBody.vertices += report->vertices;
      ofBody.tetrahedra += report->tetrahedra;
      ofBody.steps += report->steps;
      for (const int end : {0, 1}) made.capTetrahedra[end] += report->capTetrahedra[end];
      for (const std::string& notice : report->notices) {
        const std::string named =
            options.hasNames() ? fmt::format("body '{}': {}", body.name, notice) : notice;
        if (std::ranges::find(made.notices, named) == made.notices.end()) {
          made.notices.push_back(named);
        }
      }
      foldedPrisms += report->foldedPrisms;
      foldedSteps += report->foldedSteps;
      const std::string name = options.hasNames() ? body.name : "";
      for (const mesh4d::Fold& fold : report->folds) {
        folds.add(fold, name, {{"prisms", fold.prisms}, {"triangle", fold.triangle}});
      }
      soughtCrossings |= report->soughtCrossings;
      crossingPairs += report->crossingPairs;
      crossingSteps += report->crossingSteps;
      unfinishedSteps += report->unfinishedSteps;
      for (const mesh4d::StepCrossing& crossing : report->crossings) {
        crossings.add(
            crossing, name,
            {{"pairs", crossing.pairs}, {"at", crossing.at}, {"triangles", crossing.triangles}});
      }
    }
    made.vertices += ofBody.vertices;
    made.tetrahedra += ofBody.tetrahedra;
    made.steps += ofBody.steps;
    parts.push_back({{"name", body.name},
                     {"vertices", ofBody.vertices},
                     {"tetrahedra", ofBody.tetrahedra},
                     {"steps", ofBody.steps},
                     {"runs", body.runs.size()}});
  }
  made.folds = {{"prisms", foldedPrisms}, {"steps", foldedSteps}, {"first", folds.first()}};
  made.crossings = nullptr;
  if (soughtCrossings) {
    made.crossings = {{"pairs", crossingPairs},
                      {"steps", crossingSteps},
                      {"unfinished_steps", unfinishedSteps},
                      {"first", crossings.first()}};
  }
  if (options.hasNames()) made.bodies = parts;
  return made;
}

Result<Made> sweepVoxels(const SweepArguments& options, const model::TriangleMesh& mesh,
                         const model::Motion& motion, model::Sink& sink) {
  Made made;
  auto times = verbs::motionFrameTimes(options.times, *options.voxelSize, mesh, motion,
                                       options.motion, made.notices);
  if (!times) return times.error();
  if (const auto ignored = ignoredBy(options); !ignored.empty()) {
    made.notices.push_back(fmt::format("voxel4d ignores {}", fmt::join(ignored, ", ")));
  }
  const auto frames = voxel4d::voxelFrames(voxel4d::movingSolid(mesh, motion), std::move(*times),
                                           {*options.voxelSize, options.mask});
  ProgressBar bar("voxelising and weaving", frames->frameCount(), "frames");
  voxel4d::WeaveOptions how;
  how.caps = voxelCapStyle(options.caps);
  how.between = betweenOf(options.between);
  auto report = voxel4d::weave(*frames, how, sink, bar.callback());
  if (!report) return report.error();
  noticeCaps(how.caps, *report, made.notices);
  verbs::noticeLostParts(report->partsLost, made.notices);
  made.vertices = report->vertices;
  made.tetrahedra = report->tetrahedra;
  made.steps = report->frames - 1;
  made.capTetrahedra = report->capTetrahedra;
  return made;
}

/// What moves and how: solids and their motion, or bodies with keys.
struct Loaded {
  std::vector<formats::NamedMesh> solids;
  model::Motion motion;
  std::vector<formats::AnimatedBody> bodies;
  std::optional<double> tolerance;  // of an animation
  std::shared_ptr<const formats::LoadedMechanism> mechanism;
  std::optional<double> chordBound;                // of a mechanism
  std::vector<formats::BodyInfo> mechanismBodies;  // likewise
  std::vector<model::HalfTurn> halfTurns;          // likewise, and of poses
  std::string lengthUnit;
  std::string timeUnit;
  std::string up = "y";
  std::vector<std::string> losses;
  std::vector<std::string> files;               // all that were read
  std::vector<std::filesystem::path> keyFiles;  // as formats::LoadedDeformation
  std::optional<edit::MendSurfaceReport> mended;
  std::vector<std::string> materials;  // the names that the attribute `material` numbers

  void addFiles(const std::vector<std::filesystem::path>& more) {
    for (const auto& file : more) files.push_back(file.string());
  }
};

/// Sweeps solids along one motion; the file has as many bodies.
Result<Made> sweepSolids(const SweepArguments& options, const Loaded& loaded,
                         verbs::T4dFile& file) {
  Made all;
  ordered_json parts = ordered_json::array();
  for (std::size_t i = 0; i < loaded.solids.size(); ++i) {
    const formats::NamedMesh& solid = loaded.solids[i];
    const bool named = !options.dividedBy.empty();
    file.setBody(i);
    auto made = options.voxels() ? sweepVoxels(options, solid.mesh, loaded.motion, file)
                                 : sweepMesh(options, solid.mesh, loaded.motion, file);
    if (!made) {
      Error error = made.error();
      const bool motions = error.remedy == Remedy::Motion || error.remedy == Remedy::StepRule;
      if (named && error.where.empty() && !motions) {
        error.where = fmt::format("{}: body '{}'", options.models.front(), solid.name);
      }
      return error;
    }
    if (!named) return made;
    all.vertices += made->vertices;
    all.tetrahedra += made->tetrahedra;
    all.steps += made->steps;
    for (const int end : {0, 1}) all.capTetrahedra[end] += made->capTetrahedra[end];
    if (made->chordBound) {
      all.chordBound = std::max(all.chordBound.value_or(0), *made->chordBound);
    }
    for (const std::string& notice : made->notices) {
      all.notices.push_back(fmt::format("body '{}': {}", solid.name, notice));
    }
    parts.push_back({{"name", solid.name},
                     {"vertices", made->vertices},
                     {"tetrahedra", made->tetrahedra},
                     {"steps", made->steps},
                     {"runs", 1}});
  }
  all.bodies = parts;
  return all;
}

Result<formats::LoadedDeformation> readDeformation(const SweepArguments& options) {
  formats::KeyTimes times{{}, options.times.step};
  if (const auto between = numbersBetween(options.keyTimes, ':')) {
    times.between = model::TimeSpan{(*between)[0], (*between)[1]};
  }
  if (formats::isPointCache(options.models.back())) {
    return formats::readCachedMesh(options.models[0], options.models[1], times);
  }
  const std::vector<std::filesystem::path> paths(options.models.begin(), options.models.end());
  auto series = formats::readMeshSeries(paths, times);
  if (series && !series->timed && !times.between && !times.step) {
    series->solid.notices.emplace_back(kMeshesAreOneApart);
  }
  return series;
}

/// Reads everything, and prints the notices of meshes.
Result<Loaded> readInput(const SweepArguments& options) {
  Loaded loaded;
  loaded.files = options.models;
  if (isMechanism(options.models.front())) {
    auto read = MechanismInput{options.models.front(), options.motion,
                               options.geometry,       options.mend ? &options.mending : nullptr,
                               ruleOf(options),        meshOptions(options).prism,
                               options.ownSteps}
                    .read();
    if (!read) return read.error();
    loaded.mechanism = read->mechanism;
    loaded.bodies = std::move(read->bodies);
    loaded.chordBound = read->chordBound;
    loaded.mechanismBodies = std::move(read->infos);
    // By the conventions of ROS (REP 103).
    if (isUrdf(options.models.front())) loaded.up = "z";
    loaded.mended = std::move(read->mended);
    loaded.files = std::move(read->files);
    loaded.losses = loaded.mechanism->losses;
    loaded.halfTurns = loaded.mechanism->halfTurns;
    loaded.lengthUnit = loaded.mechanism->lengthUnit;
    loaded.timeUnit = loaded.mechanism->timeUnit;
    if (auto notice = model::noticeOfHalfTurns(loaded.halfTurns); !notice.empty()) {
      printNotices({notice});
    }
    return loaded;
  }
  if (options.animates()) {
    formats::GltfAnimationOptions how = options.animation;
    how.tolerance = options.maxDeviation;
    if (options.prism == 3) how.edgeFactor = model::kEdgeFactorOf3;
    auto file = formats::readInputFile(options.models.front());
    if (!file) return file.error();
    std::vector<std::string> converted;
    if (formats::isForeignScene(file->path)) {
      auto scene = formats::readForeignScene(*file);
      if (!scene) return scene.error();
      printNotices(scene->notices);
      converted = std::move(scene->losses);
      file = std::move(scene->glb);
    }
    auto read = formats::isAnimatedUsd(file->path)
                    ? formats::readUsdAnimation(std::move(*file), how)
                    : formats::readGltfAnimation(*file, how);
    if (!read) return read.error();
    printNotices(read->notices);
    loaded.bodies = std::move(read->bodies);
    loaded.tolerance = read->tolerance;
    loaded.halfTurns = std::move(read->halfTurns);
    loaded.losses = std::move(read->losses);
    loaded.losses.insert(loaded.losses.begin(), converted.begin(), converted.end());
    loaded.addFiles(read->otherFiles);
    loaded.lengthUnit = read->lengthUnit;
    loaded.timeUnit = "s";
    loaded.up = read->up;
    return loaded;
  }
  if (options.hasKeys()) {
    auto read = readDeformation(options);
    if (!read) return read.error();
    printNotices(read->solid.notices);
    loaded.losses = std::move(read->solid.losses);
    loaded.addFiles(read->solid.otherFiles);
    loaded.addFiles(read->files);
    loaded.keyFiles = std::move(read->files);
    formats::AnimatedBody body{"", std::move(read->solid.mesh), {}};
    body.runs.push_back(std::move(read->keys));
    if (options.mend) {
      auto mended =
          mendDeformation(body.mesh, body.runs.front(), options.mending, options.models.front());
      if (!mended) return mended.error();
      printNotices(noticesOf(*mended));
      loaded.mended = std::move(*mended);
    }
    loaded.bodies.push_back(std::move(body));
    return loaded;
  }
  auto read =
      MovingMeshInput{options.models.front(), options.motion,    options.mend, options.mending,
                      options.dividedBy,      !options.voxels(), options.table}
          .read();
  if (!read) return read.error();
  loaded.solids = std::move(read->bodies);
  loaded.motion = std::move(read->motion);
  loaded.halfTurns = loaded.motion.halfTurns;
  loaded.lengthUnit = loaded.motion.lengthUnit;
  loaded.timeUnit = loaded.motion.timeUnit;
  loaded.losses = std::move(read->losses);
  loaded.files = std::move(read->files);
  loaded.mended = std::move(read->mended);
  loaded.materials = std::move(read->materials);
  return loaded;
}

/// The file of the key that the place of an error begins with: a point cache, or one mesh of a
/// series.
std::string fileOfKey(const SweepArguments& options, const Loaded& loaded,
                      const std::string& where) {
  if (loaded.keyFiles.empty()) return options.models.back();
  const std::size_t key = std::strtoull(where.c_str() + std::strlen("key "), nullptr, 10);
  return loaded.keyFiles[std::min(key, loaded.keyFiles.size() - 1)].string();
}

ordered_json halfTurnsJson(const std::vector<model::HalfTurn>& turns) {
  constexpr std::size_t kMost = 100;
  ordered_json first = ordered_json::array();
  for (const model::HalfTurn& turn : turns) {
    if (first.size() == kMost) break;
    first.push_back({{"time", {turn.time.begin, turn.time.end}},
                     {"between", turn.between},
                     {"axis", {turn.axis.x(), turn.axis.y(), turn.axis.z()}}});
  }
  return {{"count", turns.size()}, {"first", first}};
}

int run(const SweepArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  std::vector<std::string> inputs = options.models;
  if (!options.motion.empty()) inputs.push_back(options.motion);
  if (const auto misuse = misuseOfOutput(options.output.path, inputs)) return wrongUsage(*misuse);
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = readInput(options);
  if (!loaded) return report(loaded.error());
  if (const auto misuse = misuseOfOutput(options.output.path, loaded->files)) {
    return wrongUsage(*misuse);
  }
  std::vector<formats::BodyInfo> bodies = loaded->mechanismBodies;
  if (options.animates()) {
    for (const auto& body : loaded->bodies) bodies.push_back({body.name});
  } else if (!options.dividedBy.empty()) {
    for (auto& solid : loaded->solids) {
      solid.name = formats::asName(solid.name);
      bodies.push_back({solid.name});
    }
  }
  if (!bodies.empty() && !options.output.body.empty()) {
    if (bodies.size() > 1) {
      return wrongUsage(fmt::format("--body names one body; the bodies are the {}",
                                    options.animates()  ? "nodes"
                                    : loaded->mechanism ? "solids of the mechanism"
                                                        : options.dividedBy + "s"));
    }
    bodies.front().name = options.output.body;
  }
  auto file = verbs::T4dFile::create(
      options.output.fileOptions(),
      {options.backend, options.models.front(), loaded->lengthUnit, loaded->timeUnit,
       detailsOf(options, loaded->materials), bodies, "", loaded->up});
  if (!file) return report(file.error());

  auto made = options.hasKeys() ? sweepKeys(options, loaded->bodies, *file)
                                : sweepSolids(options, *loaded, *file);
  if (!made) {
    Error error = made.error();
    // Errors about the mesh or the motion do not name its file.
    const bool motionsFault = error.remedy == Remedy::Motion || error.remedy == Remedy::StepRule;
    if (error.where.empty()) {
      const std::string& moving = options.hasKeys() ? options.models.back() : options.motion;
      error.where = motionsFault ? moving : options.models.front();
    } else if (error.where.starts_with("key ")) {
      error.where = fmt::format("{}: {}", fileOfKey(options, *loaded, error.where), error.where);
    }
    return report(error);
  }
  auto bytes = file->finish();
  if (!bytes) return report(bytes.error());
  printNotices(made->notices);

  if (loaded->chordBound) made->chordBound = loaded->chordBound;
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    ordered_json result{{"vertices", made->vertices},
                        {"tetrahedra", made->tetrahedra},
                        {"steps", made->steps},
                        {"cap_tetrahedra", made->capTetrahedra}};
    if (made->chordBound) result["chord_bound"] = *made->chordBound;
    if (made->bodies) {
      if (loaded->tolerance) result["tolerance"] = *loaded->tolerance;
      result["bodies"] = *made->bodies;
    }
    if (!loaded->halfTurns.empty()) result["half_turns"] = halfTurnsJson(loaded->halfTurns);
    if (made->folds) result["folds"] = *made->folds;
    if (made->crossings) result["crossings"] = *made->crossings;
    if (loaded->mended) result["mend"] = mendJson(*loaded->mended);
    result["seconds"] = seconds;
    result["peak_bytes"] = peakBytes();
    result["bytes"] = *bytes;
    printJson(result);
  } else {
    print("{}: {} vertices, {} tetrahedra\n", options.output.path, grouped(made->vertices),
          grouped(made->tetrahedra));
    if (made->bodies) {
      const std::string count = counted(made->bodies->size(), "body", "bodies");
      if (loaded->tolerance) {
        print("  {}, nowhere farther than {:.3g} from the animation\n", count, *loaded->tolerance);
      } else {
        print("  {}\n", count);
      }
    }
    print("  {}, caps of {} and {} tetrahedra\n", counted(made->steps, "step"),
          grouped(made->capTetrahedra[0]), grouped(made->capTetrahedra[1]));
    if (options.maxDeviation && made->chordBound) {
      print("  every slice within {:.3g} of the solid in motion\n", *made->chordBound);
    }
    print("  {}, {:.2f} s, peak memory {}\n", sizeText(*bytes), seconds, sizeText(peakBytes()));
    if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
  }
  std::vector<std::string> losses = std::move(loaded->losses);
  for (std::string& loss : file->losses()) losses.push_back(std::move(loss));
  return reportLosses(losses);
}

}  // namespace

void addSweep(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "sweep", "Sweep a solid along a motion, or through a deformation, into a 4D mesh");
  auto options = std::make_shared<SweepArguments>();
  command
      ->add_option("MODEL", options->models,
                   "Input solid: " + formats::readableTriangleMeshExtensions() +
                       ", or an animation, deformation or mechanism (docs/sweep.md)")
      ->required();
  command->add_option("-m,--motion", options->motion,
                      "Motion: .json, or poses as .csv, .tsv or .txt (docs/motion.md)");
  options->table.addTo(*command);
  command
      ->add_option("--geometry", options->geometry,
                   "Geometry of the links of a .urdf to sweep (default: collision)")
      ->check(CLI::IsMember({"collision", "visual"}));
  command->add_flag("--own-steps", options->ownSteps,
                    "Steps of its own for each body of a mechanism, not common ones");
  addBodiesOption(*command, options->dividedBy);
  options->mending.addTo(*command, options->mend);
  command->add_option("--animation", options->animation.animation,
                      "Animation, by name or number from 0 (default: the first)");
  command->add_option("--scene", options->animation.scene,
                      "glTF scene, by name or number from 0 (default: that of the file)");
  command
      ->add_option("--times", options->keyTimes,
                   "First and last time of a deformation (default for point caches: their times)")
      ->check(timeSpan());
  command
      ->add_option("--backend", options->backend,
                   "Method: mesh4d (sweep triangles) or voxel4d (weave voxel grids)")
      ->check(CLI::IsMember({"mesh4d", "voxel4d"}))
      ->capture_default_str();
  auto* rvMin =
      command
          ->add_option("--rv-min", options->rvMin,
                       "Minimum slice volume relative to the solid, in [0, 1) (default: 0.998)")
          ->check(fractionBelowOne());
  auto* steps = command->add_option("--steps", options->steps, "Number of steps per segment")
                    ->check(wholeNumber(1, mesh4d::kMaxSteps));
  auto* deviation =
      command
          ->add_option("--max-deviation", options->maxDeviation,
                       "Maximum distance between a slice and the true solid, in length units")
          ->check(numberAboveZero());
  // Another name, which messages repeat.
  command
      ->add_option("--tolerance", options->maxDeviation,
                   "Same as --max-deviation (default for animations: 0.001 of the largest body)")
      ->check(numberAboveZero())
      ->excludes(rvMin)
      ->excludes(steps)
      ->excludes(deviation);
  rvMin->excludes(steps)->excludes(deviation);
  steps->excludes(deviation);
  command
      ->add_option("--caps", options->caps,
                   "Caps at the ends (default: tetgen for mesh4d, flat for voxel4d)")
      ->check(CLI::IsMember({"tetgen", "cone", "flat", "half-step", "graded"}));
  command
      ->add_option("--prism", options->prism,
                   "Cells per prism: 14 (default; symmetric, exact volumes) or 3 (fewest cells)")
      ->check(CLI::IsMember({14, 3}));
  addPartOption(*command, options->part, "Sweep only part K of N; `t4d join` joins the parts");
  command
      ->add_option("--voxel-size", options->voxelSize,
                   "voxel4d: Voxel edge length, in length units")
      ->check(numberAboveZero());
  addFrameTimes(*command, options->times, "voxel4d: ", kFramesByMotion);
  command->get_option("--frame-time")
      ->description("Time between frames of voxel4d, or between keys of a deformation");
  command->add_flag("--mask", options->mask,
                    "voxel4d: Use masks of inside points instead of level sets");
  addBetween(*command, options->between, "voxel4d: ");
  options->output.addTo(*command);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n  t4d sweep bolt.obj --motion screw-in.json --up z -o bolt.t4d\n"
      "  t4d sweep bolt.obj --motion screw-in.json --backend voxel4d --voxel-size 0.5 "
      "-o bolt-voxels.t4d\n"
      "  t4d sweep frames/cloth_*.obj --frame-time 0.04 -o cloth.t4d\n"
      "  t4d sweep cloth.obj cloth.pc2 --times 0:2 -o cloth.t4d\n"
      "  t4d sweep machine.glb --tolerance 0.001 -o machine.t4d\n"
      "  t4d sweep arm.json --max-deviation 0.5 -o arm.t4d\n"
      "  t4d sweep robot.urdf --motion joints.csv -o robot.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
