#include "tools/verbs/sweep.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/body_details.h"
#include "mesh4d/cap.h"
#include "model/surface_check.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "tools/verbs/sweep_parts.h"

namespace t4d::verbs {
namespace {

/// Why these options contradict each other; "" if they do not.
std::string contradictionIn(const SweepOptions& options) {
  const auto* moved = std::get_if<MotionSweep>(&options.what);
  const auto* deformed = std::get_if<DeformationSweep>(&options.what);
  if (deformed != nullptr && deformed->files.empty()) return "no file is given";
  const bool keyed = deformed != nullptr || std::holds_alternative<AnimationSweep>(options.what);
  if (keyed && options.mending && (options.mending->remesh || options.mending->maxMove)) {
    return "mending a deformation moves no vertex: it has no limit for that, and no voxels";
  }
  if (!keyed && (options.components || options.united)) {
    return "components and unions are those of deformations and animations";
  }
  if (options.united && options.components) return "a union has no components";
  if (options.united && options.part.count > 1) return "parts are made by the mesh method alone";
  if (options.part.count == 1) return {};
  if (options.components || (deformed == nullptr && (moved == nullptr || moved->bodies))) {
    return "parts are made of the sweep of one body, not of several bodies";
  }
  if (moved != nullptr && moved->voxels) return "parts are made by the mesh method alone";
  if (options.output.center) return "a part cannot be centred: the parts would not meet";
  return {};
}

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
  if (const std::string why = contradictionIn(options); !why.empty()) {
    return fail(ErrorCode::Options, why);
  }
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

}  // namespace t4d::verbs
