#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "edit/divide_solids.h"
#include "formats/t4d/body_details.h"
#include "formats/t4d/names.h"
#include "mesh4d/cap.h"
#include "model/progress.h"
#include "model/surface_check.h"
#include "tools/t4d/sweep_parts.h"

namespace t4d::tools {
namespace {

using formats::AnimatedBody;

Place placeOf(const SweepOptions& options, const AnimatedBody& body) {
  return placeIn(modelOf(options), body.name.empty() ? "" : fmt::format("body '{}'", body.name));
}

Result<void> mendBodies(const SweepOptions& options, SweepInput& input,
                        std::vector<AnimatedBody>& bodies, Observer& observer) {
  // Components of their own may cross each other, which is known once they are.
  const auto crossings =
      options.caps == mesh4d::CapMethod::Cone || options.components || options.united
          ? edit::Crossings::Accepted
          : edit::Crossings::Refused;
  const auto stage = observer.stage("mending", bodies.size(), "bodies");
  const model::Progress progress = stage->callback();
  std::vector<Error> errors;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    AnimatedBody& body = bodies[i];
    auto mended = mendDeformedSolid(body.mesh, body.runs, *options.mending, crossings,
                                    placeOf(options, body));
    if (mended) {
      input.mended.push_back({body.name, std::move(*mended)});
    } else {
      errors.push_back(std::move(mended.error()));
    }
    if (auto on = model::report(progress, i + 1, bodies.size()); !on) return on;
  }
  if (!errors.empty()) return allErrors(std::move(errors));
  observer.noteEach(noticesOf(input.mended));
  for (std::string& loss : lossesOf(input.mended)) input.losses.push_back(std::move(loss));
  return {};
}

/// A name with a number that none of these has.
std::string numbered(const std::string& name, std::size_t& number,
                     const std::set<std::string>& taken) {
  std::string text;
  do {
    text = fmt::format("{} {}", name, ++number);
  } while (taken.contains(text));
  return text;
}

Result<double> volumeAtFirst(const AnimatedBody& body) {
  model::TriangleMesh placed{body.mesh.vertices, body.mesh.triangles, {}};
  if (auto read = body.runs.front()->positions(0, placed.vertices); !read) return read.error();
  return signedVolume(placed);
}

Result<void> divideBodies(const SweepOptions& options, SweepInput& input,
                          std::vector<AnimatedBody>& bodies) {
  std::set<std::string> taken;
  for (const AnimatedBody& body : bodies) taken.insert(body.name);
  std::vector<AnimatedBody> divided;
  input.infos.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    AnimatedBody& body = bodies[i];
    if (auto closed = model::checkClosedSurface(body.mesh); !closed) {
      Error error = closed.error();
      error.where = placeOf(options, body);
      return error;
    }
    auto solids = edit::divideSolids(body.mesh, std::move(body.runs));
    if (!solids) return solids.error();
    const std::string name =
        body.name.empty() ? formats::asName(std::filesystem::path(modelOf(options)).stem().string())
                          : body.name;
    std::size_t number = 0;
    for (edit::MovingSolid& solid : *solids) {
      divided.push_back({solids->size() == 1 ? name : numbered(name, number, taken),
                         std::move(solid.mesh), std::move(solid.runs), body.tolerance});
      input.infos.push_back({divided.back().name});
      if (input.mended.empty() || !isReshaped(input.mended[i].report)) continue;
      formats::MendedInfo info = mendedInfoOf(input.mended[i].report);
      info.volumeBefore.reset();  // was that of all components
      auto volume = volumeAtFirst(divided.back());
      if (!volume) return volume.error();
      info.volumeAfter = *volume;
      setMendedInfo(input.infos.back(), info);
    }
  }
  bodies = std::move(divided);
  input.bodyWord = "components";
  return {};
}

/// Whether each body is closed, and its ends can be filled.
bool canBeSwept(const SweepOptions& options, const std::vector<AnimatedBody>& bodies) {
  for (const AnimatedBody& body : bodies) {
    if (!model::checkClosedSurface(body.mesh)) return false;
    if (options.caps == mesh4d::CapMethod::Cone || options.united) continue;
    model::TriangleMesh placed{body.mesh.vertices, body.mesh.triangles, {}};
    for (const auto& run : body.runs) {
      for (const std::uint64_t key : {std::uint64_t{0}, run->count() - 1}) {
        if (!run->positions(key, placed.vertices)) return false;
        if (!mesh4d::fillSolid(placed, options.caps)) return false;
      }
    }
  }
  return true;
}

Result<model::Bounds3> boundsAtFirst(const std::vector<AnimatedBody>& bodies) {
  model::Bounds3 bounds;
  for (const AnimatedBody& body : bodies) {
    std::vector<model::Point3> places(body.mesh.vertices.size());
    if (auto read = body.runs.front()->positions(0, places); !read) return read.error();
    for (const model::Point3& place : places) bounds.add(place);
  }
  return bounds;
}

/// A two-hundredth of the size at the first keys, as a number with one digit.
std::optional<double> usualThickness(const std::vector<AnimatedBody>& bodies) {
  constexpr double kOfSize = 1.0 / 200;
  const auto bounds = boundsAtFirst(bodies);
  const double wanted = bounds ? kOfSize * (bounds->max - bounds->min).norm() : 0;
  if (!(wanted > 0) || !std::isfinite(wanted)) return std::nullopt;
  return std::stod(fmt::format("{:.0e}", wanted));
}

std::optional<SweepInput> readQuietly(const SweepOptions& options) {
  auto input = readSweepInput(options, nobody());
  if (!input) return std::nullopt;
  return std::move(*input);
}

}  // namespace

Result<void> makeSolids(const SweepOptions& options, SweepInput& input, Observer& observer) {
  std::vector<AnimatedBody>& bodies = std::get<BodiesWithKeys>(input.moving).bodies;
  if (options.mending) {
    if (auto mended = mendBodies(options, input, bodies, observer); !mended) return mended;
  }
  if (options.components) return divideBodies(options, input, bodies);
  if (!options.united) return {};
  const auto bounds = boundsAtFirst(bodies);
  if (!bounds) return bounds.error();
  constexpr double kOfExtent = 0.01;
  input.voxelSize =
      options.united->voxelSize.value_or(kOfExtent * (bounds->max - bounds->min).maxCoeff());
  input.infos.clear();
  return {};
}

std::optional<SweepOptions> workingOptions(const SweepOptions& options) {
  if (!std::holds_alternative<DeformationSweep>(options.what) &&
      !std::holds_alternative<AnimationSweep>(options.what)) {
    return std::nullopt;
  }
  SweepOptions plain = options;
  plain.mending.reset();
  plain.components = false;
  const auto input = readQuietly(plain);
  if (!input) return std::nullopt;
  std::vector<std::optional<double>> thicknesses = {options.mending ? options.mending->thicken
                                                                    : std::nullopt};
  if (!thicknesses.front()) {
    thicknesses.push_back(usualThickness(std::get<BodiesWithKeys>(input->moving).bodies));
  }
  struct Way {
    bool mend;
    bool components;
    bool cones;
  };
  constexpr Way kWays[] = {{false, true, false}, {false, false, true}, {true, false, false},
                           {true, true, false},  {true, false, true},  {true, true, true}};
  const bool cones = options.caps == mesh4d::CapMethod::Cone;
  for (const auto& thickness : thicknesses) {
    for (const Way& way : kWays) {
      if ((options.mending && !way.mend) || (options.components && !way.components) ||
          (cones && !way.cones) || (thickness && !way.mend) ||
          (options.united && (way.components || way.cones))) {
        continue;
      }
      SweepOptions tried = options;
      if (way.mend && !tried.mending) tried.mending.emplace();
      if (way.mend) tried.mending->thicken = thickness;
      tried.components = way.components;
      if (way.cones) tried.caps = mesh4d::CapMethod::Cone;
      const auto solids = readQuietly(tried);
      if (solids && canBeSwept(tried, std::get<BodiesWithKeys>(solids->moving).bodies)) {
        return tried;
      }
    }
  }
  return std::nullopt;
}

}  // namespace t4d::tools
