#include "tools/t4d/mechanism_input.h"

#include <algorithm>
#include <deque>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/file_extension.h"
#include "formats/motion/urdf_reader.h"
#include "formats/t4d/body_details.h"
#include "mesh4d/mechanism_keys.h"
#include "model/amount_text.h"
#include "tools/t4d/mending.h"

namespace t4d::tools {

bool isUrdf(const std::string& path) {
  const std::string extension = formats::lowerCaseExtension(path);
  return extension == ".urdf" || extension == ".xacro";  // of which the reader says what to do
}

bool isMechanism(const std::string& path) {
  return isUrdf(path) || formats::lowerCaseExtension(path) == ".json";
}

namespace {

/// The body that solid `index` hangs on: another one of its link, or of the nearest link towards
/// the world that has one.
std::string parentSolid(const formats::LoadedMechanism& mechanism, std::size_t index) {
  for (std::size_t link = mechanism.solids[index].link; link != model::Link::kWorld;
       link = mechanism.mechanism.links[link].parent) {
    const auto first = std::ranges::find(mechanism.solids, link, &formats::MechanismSolid::link);
    const bool isThis = first == mechanism.solids.begin() + static_cast<std::ptrdiff_t>(index);
    if (first != mechanism.solids.end() && !isThis) return first->name;
  }
  return {};
}

formats::BodyInfo solidInfo(const formats::LoadedMechanism& mechanism, std::size_t index) {
  const formats::MechanismSolid& solid = mechanism.solids[index];
  formats::BodyInfo info{.name = solid.name, .parent = parentSolid(mechanism, index)};
  const std::string& link = mechanism.mechanism.links[solid.link].name;
  if (link != solid.name) formats::setLink(info, link);
  return info;
}

/// Says before the work which body has the most steps, if they are so many that it takes long.
void noteManySteps(const formats::LoadedMechanism& mechanism,
                   const std::vector<mesh4d::LinkKeys>& keys, Observer& observer) {
  constexpr std::uint64_t kMany = 10'000;
  std::uint64_t most = 0;
  std::size_t body = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].keys->count() - 1 <= most) continue;
    most = keys[i].keys->count() - 1;
    body = i;
  }
  if (most < kMany) return;
  observer.note(fmt::format("body '{}' has {} steps, between {} times of its motion",
                            mechanism.solids[body].name, most,
                            mechanism.mechanism.knots(mechanism.solids[body].link).size()));
}

/// What became of the mesh of a solid.
struct MadeSolid {
  Place where;
  model::TriangleMesh given;
  model::TriangleMesh mesh;
  Result<edit::MendSurfaceReport> report;
};

/// Mends solids or takes their hulls. Those of one file that are equal are mended once.
class SolidMaker {
 public:
  SolidMaker(const MechanismInput& input, Observer& observer)
      : input_(input), observer_(observer) {}

  const MadeSolid& madeOf(const formats::MechanismSolid& solid) {
    const auto known = std::ranges::find_if(made_, [&](const MadeSolid& made) {
      return made.where.text() == solid.where.text() &&
             made.given.vertices == solid.mesh.vertices &&
             made.given.triangles == solid.mesh.triangles;
    });
    if (known != made_.end()) return *known;
    model::TriangleMesh mesh = solid.mesh;
    auto report = mendOrHull(mesh, input_.mending, input_.hull, solid.where, observer_);
    return made_.emplace_back(solid.where, solid.mesh, std::move(mesh), std::move(report));
  }

 private:
  const MechanismInput& input_;
  Observer& observer_;
  std::deque<MadeSolid> made_;
};

/// Mends the solids or takes their hulls, and leaves out those without volume.
Result<void> makeSolids(const MechanismInput& input, formats::LoadedMechanism& mechanism,
                        MechanismBodies& loaded, Observer& observer) {
  std::vector<formats::MechanismSolid> solids;
  std::vector<std::string> flat;
  std::vector<Error> errors;
  SolidMaker maker(input, observer);
  for (formats::MechanismSolid& solid : mechanism.solids) {
    const MadeSolid& made = maker.madeOf(solid);
    if (made.report) {
      solid.mesh = made.mesh;
      loaded.mended.push_back({solid.name, *made.report});
      solids.push_back(std::move(solid));
    } else {
      flat.push_back(solid.name);
      errors.push_back(made.report.error());
    }
  }
  // What has no hull for another reason, such as a build without CGAL, is not flat.
  const auto isFlat = [](const Error& error) { return error.code == ErrorCode::InvalidInput; };
  const bool fails =
      solids.empty() || input.hull == Hull::Never || !std::ranges::all_of(errors, isFlat);
  if (!errors.empty() && fails) return allErrors(std::move(errors));
  mechanism.solids = std::move(solids);
  if (flat.empty()) return {};
  loaded.losses.push_back(fmt::format("{} without volume: {}",
                                      model::counted(flat.size(), "body", "bodies"),
                                      fmt::join(flat, ", ")));
  return {};
}

}  // namespace

Result<MechanismBodies> readMechanismBodies(const MechanismInput& input, Observer& observer) {
  const formats::UrdfOptions how{input.geometry, input.packages};
  auto read = isUrdf(input.path) ? formats::readUrdf(input.path, input.motion, how)
                                 : formats::readMechanism(input.path);
  if (!read) return read.error();
  for (const std::string& notice : read->notices) observer.note(input.path + ": " + notice);
  MechanismBodies loaded;
  if (auto made = makeSolids(input, *read, loaded, observer); !made) return made.error();
  const auto mechanism = std::make_shared<const formats::LoadedMechanism>(std::move(*read));
  std::vector<mesh4d::LinkSolid> solids;
  for (const formats::MechanismSolid& solid : mechanism->solids) {
    solids.push_back({&solid.mesh, solid.link, solid.place});
  }
  auto keys = mesh4d::mechanismKeys(mechanism->mechanism, solids, input.steps, input.prism,
                                    !input.ownSteps, input.maxSteps);
  if (!keys) {
    if (keys.error().where.empty()) keys.error().where = input.path;
    return keys.error();
  }
  noteManySteps(*mechanism, *keys, observer);
  for (std::size_t i = 0; i < solids.size(); ++i) {
    formats::AnimatedBody body{mechanism->solids[i].name, mechanism->solids[i].mesh, {}};
    body.runs.push_back(std::move((*keys)[i].keys));
    loaded.chordBound = std::max(loaded.chordBound, (*keys)[i].chordBound);
    loaded.bodies.push_back(std::move(body));
    loaded.infos.push_back(solidInfo(*mechanism, i));
    if (mechanism->mechanism.moves(mechanism->solids[i].link)) {
      formats::setChordBound(loaded.infos.back(), (*keys)[i].chordBound);
    }
  }
  loaded.files.push_back(input.path);
  for (const auto& file : mechanism->otherFiles) loaded.files.push_back(file.string());
  loaded.mechanism = mechanism;
  return loaded;
}

}  // namespace t4d::tools
