#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/formats/gltf/gltf_animation.h"
#include "t4d/formats/motion/mechanism_reader.h"
#include "t4d/formats/t4d/metadata.h"
#include "t4d/mesh4d/prism.h"
#include "t4d/mesh4d/steps.h"
#include "tools/program/mending.h"

namespace t4d::tools {

/// Whether a model is a mechanism: a .json or a .urdf.
bool isMechanism(const std::string& path);
bool isUrdf(const std::string& path);

/// A mechanism, and how its solids become 4D meshes.
struct MechanismInput {
  std::string path;
  std::string motion = {};                  ///< of a .urdf: the table of its joints
  std::string geometry = {};                ///< of a .urdf, as formats::UrdfOptions; "" for default
  const MendingOptions* mending = nullptr;  ///< null: solids as they are
  mesh4d::StepRule steps = {};
  mesh4d::PrismSplit prism = mesh4d::PrismSplit::Fourteen;
  bool ownSteps = false;

  struct Loaded {
    std::shared_ptr<const formats::LoadedMechanism> mechanism;  ///< that the keys refer to
    std::vector<formats::AnimatedBody> bodies;
    std::vector<formats::BodyInfo> infos = {};  ///< of each body
    double chordBound = 0;
    std::vector<std::string> files = {};  ///< all that were read
    std::optional<edit::MendSurfaceReport> mended = {};
  };
  /// Reads the mechanism, and prints its notices.
  Result<Loaded> read() const;
};

}  // namespace t4d::tools
