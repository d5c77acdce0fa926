#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/formats/usd/usd_text.h"
#include "t4d/formats/usd/usd_xform.h"
#include "t4d/model/times.h"

namespace t4d::formats {

/// A Mesh prim and all that says where and when it is.
struct UsdPlacedMesh {
  const UsdPrim* prim = nullptr;
  std::string name;                                 ///< its `displayName`, or that of the prim
  std::vector<UsdXformOp> ops = {};                 ///< of it and its parents, the outermost first
  std::vector<const UsdProperty*> visibility = {};  ///< of it and its parents

  /// From its coordinates to those of the stage.
  Eigen::Affine3d world(double time) const;
  bool moves() const;
};

/// The meshes of a stage: prims that are defined and active, but for guides and proxies. Times are
/// in seconds.
struct UsdScene {
  std::shared_ptr<const UsdDocument> document;
  std::shared_ptr<const UsdLayer> layer;
  double timeCodesPerSecond = 24;
  std::string lengthUnit;  ///< in which coordinates are; metres where USD has no unit of a name
  std::string up;          ///< "y" or "z"
  model::TimeSpan played;  ///< startTimeCode to endTimeCode, or from the first sample to the last
  double beginCode = 0;    ///< the time code of its beginning
  bool animated = false;   ///< something has time samples
  std::vector<UsdPlacedMesh> meshes;
  std::vector<std::string> notices;
  std::vector<std::string> losses;

  double seconds(double timeCode) const { return timeCode / timeCodesPerSecond; }
  /// At the first time.
  bool isHidden(const UsdPlacedMesh& mesh) const;
  /// When a mesh is visible: spans within the time that is played.
  std::vector<model::TimeSpan> visibleTimes(const UsdPlacedMesh& mesh) const;
};

/// Reads what is where. Fails on what one text does not have: references, payloads, inherits,
/// variants, value clips; and on skeletons and instancers.
Result<UsdScene> readUsdScene(InputFile file);

}  // namespace t4d::formats
