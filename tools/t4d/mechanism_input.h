#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/gltf_animation.h"
#include "formats/motion/mechanism_reader.h"
#include "formats/motion/package_path.h"
#include "mesh4d/prism.h"
#include "mesh4d/steps.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

/// Whether a file is a mechanism by its name: a .json or a .urdf.
bool isMechanism(const std::string& path);
bool isUrdf(const std::string& path);

/// A mechanism, and how its solids become 4D meshes.
struct MechanismInput {
  std::string path;
  std::string motion = {};    ///< of a .urdf: the table of its joints
  std::string geometry = {};  ///< of a .urdf, as formats::UrdfOptions; "" for default
  mesh4d::StepRule steps = {};
  mesh4d::PrismSplit prism = mesh4d::PrismSplit::Fourteen;
  bool ownSteps = false;  ///< of each body, and not common ones
  edit::MendSurfaceOptions mending = {};
  Hull hull = Hull::Fallback;
  formats::Packages packages = {};             ///< of a .urdf, as formats::UrdfOptions
  std::optional<std::uint64_t> maxSteps = {};  ///< as mesh4d::mechanismKeys
};

struct MechanismBodies {
  std::shared_ptr<const formats::LoadedMechanism> mechanism;  ///< that the keys refer to
  std::vector<formats::AnimatedBody> bodies;
  std::vector<formats::BodyInfo> infos = {};  ///< of each body
  double chordBound = 0;                      ///< in length units, of all bodies
  std::vector<std::string> files = {};        ///< all that were read
  std::vector<MendedBody> mended = {};        ///< of each body
  std::vector<std::string> losses = {};       ///< solids without volume, which are left out
};

/// Reads a mechanism, whose solids are mended or become their hulls. The observer gets its notices.
/// Solids without volume are left out, unless all are or Hull::Never is given. If several solids
/// cannot be mended, the error has those of the others (Error::others).
Result<MechanismBodies> readMechanismBodies(const MechanismInput& input, Observer& observer);

}  // namespace t4d::tools
