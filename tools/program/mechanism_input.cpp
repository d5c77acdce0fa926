#include "tools/program/mechanism_input.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/motion/urdf_reader.h"
#include "t4d/formats/t4d/body_details.h"
#include "t4d/mesh4d/mechanism_keys.h"
#include "tools/program/console.h"

namespace t4d::tools {

bool isUrdf(const std::string& path) { return formats::lowerCaseExtension(path) == ".urdf"; }

bool isMechanism(const std::string& path) {
  return isUrdf(path) || formats::lowerCaseExtension(path) == ".json";
}

namespace {

/// The body that solid `index` hangs on: another one of its link, or of the nearest link towards
/// the world that has one.
std::string parentOf(const formats::LoadedMechanism& mechanism, std::size_t index) {
  for (std::size_t link = mechanism.solids[index].link; link != model::Link::kWorld;
       link = mechanism.mechanism.links[link].parent) {
    const auto first = std::ranges::find(mechanism.solids, link, &formats::MechanismSolid::link);
    const bool isThis = first == mechanism.solids.begin() + static_cast<std::ptrdiff_t>(index);
    if (first != mechanism.solids.end() && !isThis) return first->name;
  }
  return {};
}

formats::BodyInfo infoOf(const formats::LoadedMechanism& mechanism, std::size_t index) {
  const formats::MechanismSolid& solid = mechanism.solids[index];
  formats::BodyInfo info{.name = solid.name, .parent = parentOf(mechanism, index)};
  const std::string& link = mechanism.mechanism.links[solid.link].name;
  if (link != solid.name) formats::setLink(info, link);
  return info;
}

}  // namespace

Result<MechanismInput::Loaded> MechanismInput::read() const {
  formats::UrdfOptions how;
  if (!geometry.empty()) how.geometry = geometry;
  auto read = isUrdf(path) ? formats::readUrdf(path, motion, how) : formats::readMechanism(path);
  if (!read) return read.error();
  for (const std::string& notice : read->notices) printNotices({path + ": " + notice});
  Loaded loaded;
  for (formats::MechanismSolid& solid : read->solids) {
    if (mending == nullptr) continue;
    auto done = mend(solid.mesh, *mending, solid.where);
    if (!done) return done.error();
    addMended(*done, solid.name, loaded.mended);
  }
  if (loaded.mended) printNotices(noticesOf(*loaded.mended));
  const auto mechanism = std::make_shared<const formats::LoadedMechanism>(std::move(*read));
  std::vector<mesh4d::LinkSolid> solids;
  for (const formats::MechanismSolid& solid : mechanism->solids) {
    solids.push_back({&solid.mesh, solid.link, solid.place});
  }
  auto keys = mesh4d::mechanismKeys(mechanism->mechanism, solids, steps, prism, !ownSteps);
  if (!keys) {
    if (keys.error().where.empty()) keys.error().where = path;
    return keys.error();
  }
  for (std::size_t i = 0; i < solids.size(); ++i) {
    formats::AnimatedBody body{mechanism->solids[i].name, mechanism->solids[i].mesh, {}};
    body.runs.push_back(std::move((*keys)[i].keys));
    loaded.chordBound = std::max(loaded.chordBound, (*keys)[i].chordBound);
    loaded.bodies.push_back(std::move(body));
    loaded.infos.push_back(infoOf(*mechanism, i));
    if (mechanism->mechanism.moves(mechanism->solids[i].link)) {
      formats::setChordBound(loaded.infos.back(), (*keys)[i].chordBound);
    }
  }
  loaded.files.push_back(path);
  for (const auto& file : mechanism->otherFiles) loaded.files.push_back(file.string());
  loaded.mechanism = mechanism;
  return loaded;
}

}  // namespace t4d::tools
