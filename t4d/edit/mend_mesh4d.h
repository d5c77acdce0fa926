#pragma once

#include <optional>
#include <string>
#include <vector>

#include "t4d/formats/mesh4d/mesh4d.h"

namespace t4d::edit {

struct Mend4dOptions {
  /// Merge vertices no farther apart than this along each axis, time included; 0: equal ones.
  /// Without it, equal vertices are merged only if the mesh is open.
  std::optional<double> weld = {};
  /// Accept a mesh that is not closed or cannot be oriented.
  bool allowOpen = false;
};

struct Mend4dReport {
  bool closed = false;    ///< every triangle has exactly two tetrahedra
  bool oriented = false;  ///< on opposite sides
  /// What was changed, or is wrong all the same, a sentence each.
  std::vector<std::string> changes;
};

/// Makes a body of a foreign mesh: closed, oriented, facing outward. Changes only what there is one
/// way to change:
/// * vertices are merged, as the options say;
/// * tetrahedra that disagree with their neighbours are turned, such that each connected part
///   encloses a positive hypervolume. A cavity then becomes a solid: nothing in a mesh without
///   orientation tells them apart;
/// * a mesh that is oriented but encloses a negative hypervolume is turned inside out.
///
/// Fails if the mesh is not closed or cannot be oriented, naming the first triangle at fault, or
/// encloses no hypervolume, unless the options allow it.
Result<Mend4dReport> mendMesh4d(formats::Mesh4d& mesh, const Mend4dOptions& options = {});

}  // namespace t4d::edit
