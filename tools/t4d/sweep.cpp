#include "tools/t4d/sweep.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/animation/deformation_reader.h"
#include "formats/animation/mesh_steps.h"
#include "formats/file_extension.h"
#include "formats/t4d/body_details.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "mesh4d/cap.h"
#include "model/surface_check.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "tools/t4d/bodies_option.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/frame_order.h"
#include "tools/t4d/hints.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/mechanism_input.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/motion_options.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/sweep_parts.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/voxel_series.h"

namespace t4d::tools {
namespace {

/// The names of the bodies, of which one can be given.
Result<std::vector<formats::BodyInfo>> namedBodies(const SweepInput& input,
                                                   const std::string& name) {
  std::vector<formats::BodyInfo> bodies = input.infos;
  if (bodies.empty() || name.empty()) return bodies;
  if (bodies.size() > 1) {
    return fail(ErrorCode::Options,
                fmt::format("a name is given for one body; the bodies are the {}", input.bodyWord));
  }
  bodies.front().name = name;
  return bodies;
}

/// Lets the file say which bodies were mended, but for components, which say so already. One
/// without a name has its info only then.
void noteMending(const SweepInput& input, const std::string& name,
                 std::vector<formats::BodyInfo>& bodies) {
  if (std::max<std::size_t>(bodies.size(), 1) != input.mended.size()) return;
  for (std::size_t i = 0; i < input.mended.size(); ++i) {
    const edit::MendSurfaceReport& report = input.mended[i].report;
    if (!isReshaped(report)) continue;
    if (bodies.empty()) bodies.push_back({name});
    setMendedInfo(bodies[i], mendedInfoOf(report));
  }
}

/// What helps where a mended surface cannot be filled is not to mend it.
Error withoutMending(Error error) {
  if (error.remedy == Remedy::ConeCaps) error.remedy = Remedy::ConeCapsAlone;
  if (error.remedy == Remedy::Mend) error.remedy = Remedy::None;
  for (Error& other : error.others) other = withoutMending(std::move(other));
  return error;
}

}  // namespace

std::optional<Error> faultOf(const model::TriangleMesh& solid, const SweepOptions& options,
                             const Place& where) {
  auto sound = model::checkClosedSurface(solid);
  if (sound && options.caps == mesh4d::CapMethod::TetGen) {
    if (auto filled = mesh4d::fillSolid(solid, options.caps); !filled) sound = filled.error();
  }
  if (sound) return std::nullopt;
  Error error = std::move(sound.error());
  if (error.where.empty()) error.where = where;
  return error;
}

mesh4d::SweepOptions meshMethodOf(const SweepOptions& options) {
  mesh4d::SweepOptions how{.caps = options.caps, .prism = options.prism, .part = options.part};
  if (const auto* moved = std::get_if<MotionSweep>(&options.what)) {
    how.steps = moved->steps;
    how.maxSteps = moved->maxSteps;
  }
  return how;
}

Result<SweepReport> sweep(const SweepOptions& options, Observer& observer) {
  const platform::KeptInputs kept;
  const platform::Stopwatch stopwatch;
  auto input = readSweepInput(options, observer);
  if (!input) return input.error();
  auto bodies = namedBodies(*input, options.output.body);
  if (!bodies) return bodies.error();
  noteMending(*input, options.output.body, *bodies);
  const auto* moved = std::get_if<MotionSweep>(&options.what);
  const bool byVoxels = options.united || (moved != nullptr && moved->voxels);
  auto file = T4dFile::create(
      options.output, {byVoxels ? "voxel4d" : "mesh4d", modelOf(options), input->lengthUnit,
                       input->timeUnit, sweepDetails(options, *input), *bodies, "", input->up});
  if (!file) return file.error();
  const auto how = moved != nullptr ? sweepByMotion
                   : options.united ? sweepUnion
                                    : sweepThroughKeys;
  auto report = how(options, *input, *file, observer);
  if (!report) return options.mending ? withoutMending(report.error()) : report.error();
  const auto bytes = file->finish();
  if (!bytes) return bytes.error();

  report->bytes = *bytes;
  if (input->chordBound) report->chordBound = input->chordBound;
  report->halfTurns = std::move(input->halfTurns);
  report->mended = std::move(input->mended);
  report->losses.insert(report->losses.begin(), input->losses.begin(), input->losses.end());
  report->otherAnimations = std::move(input->otherAnimations);
  for (std::string& loss : file->losses()) report->losses.push_back(std::move(loss));
  report->seconds = stopwatch.seconds();
  return report;
}

namespace {

struct SweepArguments {
  std::vector<std::string> models;
  std::string motion;  // "" for solids that are deformed
  MotionOptions table;
  bool mend = false;
  MendingOptions mending;
  std::string dividedBy;  // --bodies
  std::string keyTimes;
  std::string animation;
  std::string scene;
  std::string geometry;               // of a .urdf
  std::optional<std::string> hull;    // of a mechanism
  std::vector<std::string> packages;  // of a .urdf: NAME=FOLDER
  bool ownSteps = false;
  bool unite = false;  // --union
  std::string backend = "mesh4d";
  std::optional<double> rvMin;
  std::optional<std::uint64_t> steps;
  std::optional<double> maxDeviation;
  std::optional<std::uint64_t> maxSteps;
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
};

constexpr const char* kUnionIsFor = "--union is for an animation and a solid that is deformed";

/// The error message if options do not fit a mechanism.
std::optional<std::string> misuseOfMechanism(const SweepArguments& options) {
  if (options.models.size() > 1) return "a mechanism is given alone: it names its solids";
  const bool urdf = isUrdf(options.models.front());
  if (options.unite) return kUnionIsFor;
  if (urdf && options.motion.empty()) {
    return "--motion is required for a .urdf: a table of its joints over time (docs/mechanism.md)";
  }
  if (!urdf && !options.motion.empty()) {
    return "--motion is not for a mechanism, which names its motions itself";
  }
  if (!urdf && !(options.geometry.empty() && options.packages.empty())) {
    return "--geometry and --package are for a .urdf";
  }
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
  if (!options.animation.empty() || !options.scene.empty()) {
    return "--animation and --scene are for an animated glTF";
  }
  return std::nullopt;
}

/// The error message if the options that give the motion do not fit the kind of sweep.
std::optional<std::string> misuseOfMotion(const SweepArguments& options, SweepKind kind) {
  if (kind == SweepKind::Mechanism) return misuseOfMechanism(options);
  if (options.ownSteps || !options.geometry.empty() || options.hull || !options.packages.empty()) {
    return "--own-steps, --geometry, --package and --hull are for a mechanism (.json or .urdf)";
  }
  const bool namesPart = !options.animation.empty() || !options.scene.empty();
  if (namesPart && kind != SweepKind::Animation) {
    return "--animation and --scene are for an animated glTF";
  }
  const bool collected = std::ranges::any_of(
      options.models, [](const auto& model) { return formats::isCollection(model); });
  if (collected && options.models.size() > 1) {
    return "a collection (.pvd) is given alone: it lists the meshes";
  }
  if (kind == SweepKind::Motion) {
    if (collected || options.models.size() > 1) {
      return "--motion is for one solid; several meshes, their collection (.pvd), or a point cache "
             "move by themselves";
    }
    if (!options.keyTimes.empty()) return "--times is for a solid that is deformed";
    if (options.unite) return kUnionIsFor;
    if (options.dividedBy == kComponents) {
      return "--bodies component is for an animation and a solid that is deformed";
    }
    return std::nullopt;
  }
  if (!options.dividedBy.empty() && options.dividedBy != kComponents) {
    return "--bodies object and --bodies group are for --motion";
  }
  if (!options.table.table.empty()) {
    return "--angles, --quaternion, --length-unit and --time-unit are for --motion";
  }
  if (options.mend && (options.mending.limits.remesh || options.mending.limits.maxMove)) {
    return "--remesh and --max-move are for --motion: mending a deformation moves no vertex";
  }
  if (options.voxels())
    return "--backend voxel4d needs --motion; --union is for what moves by itself";
  if (options.unite && (!options.dividedBy.empty() || options.part || options.prism ||
                        (!options.caps.empty() && !isVoxelCaps(options.caps)))) {
    return "--union makes one solid by voxels: without --bodies, --part, --prism, and --caps of "
           "mesh4d";
  }
  if (options.maxSteps) return "--max-steps is for --motion and for mechanisms";
  if (kind == SweepKind::Animation) {
    if (options.rvMin || options.steps || !options.keyTimes.empty() ||
        (options.times.step && !options.unite)) {
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
    return "--motion is required, but for an animated .glb or .gltf, for a mechanism "
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
std::optional<std::string> misuseOf(const SweepArguments& options, SweepKind kind) {
  if (const auto misuse = misuseOfMotion(options, kind)) return misuse;
  if (options.voxels()) {
    if (!options.voxelSize) return "--backend voxel4d needs --voxel-size";
    if (options.part) return "--part is for --backend mesh4d";
    return std::nullopt;
  }
  if (options.unite) {
    return options.mask || options.between
               ? std::optional("--mask and --between are for --backend voxel4d")
               : std::nullopt;
  }
  const bool frameTime = options.times.step && kind == SweepKind::Motion;
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

/// Options that voxel4d ignores, so that both backends accept the same arguments.
std::vector<std::string> ignoredBy(const SweepArguments& options) {
  std::vector<std::string> names;
  if (options.rvMin) names.emplace_back("--rv-min");
  if (options.steps) names.emplace_back("--steps");
  if (options.maxDeviation) names.emplace_back("--max-deviation");
  if (options.maxSteps) names.emplace_back("--max-steps");
  if (options.prism) names.emplace_back("--prism");
  if (!options.caps.empty() && !isVoxelCaps(options.caps)) names.emplace_back("--caps");
  return names;
}

mesh4d::StepRule ruleOf(const SweepArguments& options) {
  if (options.steps) return mesh4d::StepsPerSegment{*options.steps};
  if (options.maxDeviation) return mesh4d::MaxDeviation{*options.maxDeviation};
  return mesh4d::MinVolumeRatio{options.rvMin.value_or(mesh4d::MinVolumeRatio{}.ratio)};
}

MotionSweep motionSweepOf(const SweepArguments& options) {
  MotionSweep what{options.models.front(), options.motion, options.table.table,
                   bodiesBy(options.dividedBy), ruleOf(options)};
  what.maxSteps = options.maxSteps.value_or(mesh4d::kMaxSteps);
  if (options.voxels()) {
    what.voxels = VoxelMethod{*options.voxelSize,
                              options.times,
                              options.mask,
                              chosenBetween(options.between),
                              voxelCapStyle(options.caps),
                              ignoredBy(options)};
  }
  return what;
}

DeformationSweep deformationSweepOf(const SweepArguments& options) {
  DeformationSweep what{options.models, {{}, options.times.step}};
  if (const auto between = numbersBetween(options.keyTimes, ':')) {
    what.times.between = model::TimeSpan{(*between)[0], (*between)[1]};
  }
  return what;
}

/// Between keys of a deformation there is its own time.
voxel4d::FrameTimes unionTimes(const SweepArguments& options, SweepKind kind) {
  if (kind == SweepKind::Animation) return options.times;
  return {options.times.count, {}};
}

formats::Packages packagesOf(const SweepArguments& options) {
  formats::Packages packages;
  for (const std::string& text : options.packages) {
    const auto equals = text.find('=');
    packages[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return packages;
}

std::optional<Hull> hullOf(const SweepArguments& options) {
  if (!options.hull) return std::nullopt;
  return *options.hull == "never"    ? Hull::Never
         : *options.hull == "always" ? Hull::Always
                                     : Hull::Fallback;
}

SweepOptions sweepOptionsOf(const SweepArguments& options, SweepKind kind) {
  SweepOptions how;
  const std::string& file = options.models.front();
  switch (kind) {
    case SweepKind::Motion:
      how.what = motionSweepOf(options);
      break;
    case SweepKind::Deformation:
      how.what = deformationSweepOf(options);
      break;
    case SweepKind::Animation:
      how.what = AnimationSweep{file, options.animation, options.scene, options.maxDeviation};
      break;
    case SweepKind::Mechanism:
      how.what = MechanismSweep{file,
                                options.motion,
                                options.geometry,
                                ruleOf(options),
                                options.ownSteps,
                                options.maxSteps,
                                hullOf(options),
                                packagesOf(options)};
      break;
  }
  how.mending = options.mending.given(options.mend);
  how.components = options.dividedBy == kComponents;
  if (options.unite) {
    how.united =
        VoxelUnion{options.voxelSize, unionTimes(options, kind), voxelCapStyle(options.caps)};
  }
  // What the ends are filled with means nothing to those who move a robot, and cones always can.
  const bool cones = options.caps.empty() && kind == SweepKind::Mechanism;
  if (cones || options.caps == "cone") how.caps = mesh4d::CapMethod::Cone;
  if (options.prism == 3) how.prism = mesh4d::PrismSplit::Three;
  how.part = options.part.value_or(model::Part());
  how.output = options.output.fileOptions();
  return how;
}

/// Whether mending, dividing or another way to close the ends may help.
bool isAboutSolids(const Error& error) {
  switch (error.remedy) {
    case Remedy::Mend:
    case Remedy::Thicken:
    case Remedy::ConeCaps:
    case Remedy::ConeCapsAlone:
      return true;
    default:
      return std::ranges::any_of(error.others, isAboutSolids);
  }
}

/// The options that were added, as words.
std::string addedTo(const SweepOptions& given, const SweepOptions& working) {
  std::string words;
  if (working.mending && !given.mending) words += " --mend";
  if (working.mending && working.mending->thicken && !(given.mending && given.mending->thicken)) {
    words += fmt::format(" --thicken {}", *working.mending->thicken);
  }
  if (working.components && !given.components) words += " --bodies component";
  if (working.caps != given.caps) words += " --caps cone";
  return words;
}

/// Reports an error, and what helps with this very file if it is found.
int reportSolids(const SweepOptions& options, Error error) {
  const auto working = isAboutSolids(error) ? workingOptions(options) : std::nullopt;
  if (!working) return report(error);
  error.remedy = Remedy::None;
  for (Error& other : error.others) other.remedy = Remedy::None;
  const int code = report(error);
  sayHint("try:" + addedTo(options, *working));
  return code;
}

void printReport(const SweepReport& report, const SweepArguments& options) {
  print("{}: {} vertices, {} tetrahedra\n", options.output.path, grouped(report.vertices),
        grouped(report.tetrahedra));
  if (!report.bodies.empty()) {
    const std::string count = counted(report.bodies.size(), "body", "bodies");
    if (report.tolerance) {
      print("  {}, nowhere farther than {:.3g} from the animation\n", count, *report.tolerance);
    } else {
      print("  {}\n", count);
    }
  }
  if (report.voxelSize) print("  from voxels of {:.6g}\n", *report.voxelSize);
  print("  {}, caps of {} and {} tetrahedra\n", counted(report.steps, "step"),
        grouped(report.capTetrahedra[0]), grouped(report.capTetrahedra[1]));
  if (options.maxDeviation && report.chordBound) {
    print("  every slice within {:.3g} of the solid in motion\n", *report.chordBound);
  }
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(report.bytes), report.seconds,
        sizeText(peakBytes()));
  const bool robot = sweepKindOf(options.models, options.motion) == SweepKind::Mechanism;
  if (robot && std::ranges::any_of(
                   report.mended, [](const MendedBody& body) { return isReshaped(body.report); })) {
    std::vector<std::vector<std::string>> rows = rowsOf(report.mended);
    for (auto& row : rows) row.front().insert(0, "  ");
    printTable(rows, "llr");
  }
  if (const auto rounding = options.output.coding.rounding()) print("  {}\n", *rounding);
}

int run(const SweepArguments& options) {
  for (const std::string& model : options.models) {
    if (!exportHint(model).empty()) return report(formats::checkMeshExtension(model).error());
  }
  const SweepKind kind = sweepKindOf(options.models, options.motion);
  if (const auto misuse = misuseOf(options, kind)) return wrongUsage(*misuse);
  ConsoleObserver observer;
  const SweepOptions how = sweepOptionsOf(options, kind);
  const auto done = sweep(how, observer);
  if (!done) return reportSolids(how, done.error());
  observer.noteEach(done->notices);
  if (const auto& others = done->otherAnimations; !others.empty() && options.animation.empty()) {
    observer.note(
        fmt::format("the first animation of {} is read; --animation takes another ({}), "
                    "or all",
                    others.size() + 1, fmt::join(others, ", ")));
  }
  if (options.json) {
    printAsJson(*done);
  } else {
    printReport(*done, options);
  }
  return reportLosses(done->losses);
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
      ->add_option(
          "--geometry", options->geometry,
          "Geometry of the links of a .urdf to sweep (default: collision or, without any, visual)")
      ->check(CLI::IsMember({"collision", "visual"}));
  command->add_flag(
      "--own-steps", options->ownSteps,
      "Divide the motion of each body of a mechanism into its own steps (default: common steps)");
  command
      ->add_option("--package", options->packages,
                   "Folder of a package that meshes of a .urdf are in; repeatable")
      ->allow_extra_args(false)
      ->check(CLI::Validator(
          [](std::string& text) {
            const auto equals = text.find('=');
            const bool good = equals != text.npos && equals > 0 && equals + 1 < text.size();
            return good ? std::string() : fmt::format("'{}' is not NAME=FOLDER", text);
          },
          "NAME=FOLDER"));
  command
      ->add_option("--hull", options->hull,
                   "Sweep the convex hull of a solid of a mechanism: where mending it fails or "
                   "would drop some of it (default), never, or always")
      ->check(CLI::IsMember({"never", "fallback", "always"}));
  addBodiesOption(*command, options->dividedBy, /*components=*/true);
  options->mending.addTo(*command, options->mend);
  command->add_flag("--union", options->unite,
                    "Make one solid of all bodies of an animation or a deformation, which may "
                    "overlap, from voxels (--voxel-size, default: 0.01 of the largest extent)");
  command->add_option("--animation", options->animation,
                      "Animation by name or number, or all at once (default: the first)");
  command->add_option("--scene", options->scene,
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
                   "Same as --max-deviation (default for animations: 0.001 of each body)")
      ->check(numberAboveZero())
      ->excludes(rvMin)
      ->excludes(steps)
      ->excludes(deviation);
  command
      ->add_option("--max-steps", options->maxSteps,
                   "Maximum number of steps to accept (see docs/limits.md)")
      ->check(wholeNumber(1, mesh4d::kMaxSteps));
  rvMin->excludes(steps)->excludes(deviation);
  steps->excludes(deviation);
  command
      ->add_option(
          "--caps", options->caps,
          "Caps at the ends (default: tetgen for mesh4d, cone for mechanisms, flat for voxel4d)")
      ->check(CLI::IsMember({"tetgen", "cone", "flat", "half-step", "graded"}));
  command
      ->add_option("--prism", options->prism,
                   "Cells per prism: 14 (default; symmetric, exact volumes) or 3 (fewest cells)")
      ->check(CLI::IsMember({14, 3}));
  addPartOption(*command, options->part, "Sweep only part K of N; `t4d join` joins the parts");
  command
      ->add_option("--voxel-size", options->voxelSize,
                   "voxel4d, --union: Voxel edge length, in length units")
      ->check(numberAboveZero());
  addFrameTimes(*command, options->times, "voxel4d, --union: ", kFramesByMotion);
  command->get_option("--frame-time")
      ->description("Time between frames of voxel4d, or between keys of a deformation");
  command->add_flag("--mask", options->mask,
                    "voxel4d: Use masks of inside points instead of level sets");
  addBetween(*command, options->between, "voxel4d: ");
  options->output.addTo(*command);
  addJsonOption<SweepReport>(*command, options->json, "What was made: a 4D mesh in a .t4d file.");
  command->footer(
      "Example:\n  t4d sweep bolt.obj --motion screw-in.json --up z -o bolt.t4d\n"
      "  t4d sweep bolt.obj --motion screw-in.json --backend voxel4d --voxel-size 0.5 "
      "-o bolt-voxels.t4d\n"
      "  t4d sweep frames/cloth_*.obj --frame-time 0.04 -o cloth.t4d\n"
      "  t4d sweep cloth.obj cloth.pc2 --times 0:2 -o cloth.t4d\n"
      "  t4d sweep machine.glb --tolerance 0.001 -o machine.t4d\n"
      "  t4d sweep arm.json --max-deviation 0.5 -o arm.t4d\n"
      "  t4d sweep robot.urdf --motion joints.csv -o robot.t4d");
  command->callback([=, &exitCode] {
    if (const auto notice = orderFrames(options->models); !notice.empty()) printNotices({notice});
    exitCode = run(*options);
  });
}

}  // namespace t4d::tools
