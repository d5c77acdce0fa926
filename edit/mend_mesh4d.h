#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/mesh4d/mesh4d.h"

namespace t4d::edit {

struct Mend4dOptions {
  /// Merge vertices no farther apart than this along each axis, time included; 0 merges equal ones.
  /// By default, equal vertices are merged only if the mesh is open.
  std::optional<double> weld = {};
  /// Accept a mesh that is not closed or cannot be oriented.
  bool allowOpen = false;
};

struct Mend4dReport {
  bool closed = false;    ///< every triangle has exactly two tetrahedra
  bool oriented = false;  ///< the two are on opposite sides
  /// What was changed, and what is still wrong, one sentence each.
  std::vector<std::string> changes;
};

/// Makes a body of another program's mesh: closed, oriented, facing outward. Makes only changes
/// without a choice:
/// * vertices are merged, according to the options;
/// * tetrahedra that disagree with their neighbours are turned, so that each connected part
///   encloses a positive hypervolume. A cavity becomes a solid, since a mesh without orientation
///   does not distinguish the two;
/// * a mesh that is oriented but encloses a negative hypervolume is turned inside out.
///
/// Fails if the mesh is not closed or cannot be oriented, naming the first triangle at fault, or
/// encloses no hypervolume, unless the options allow it.
Result<Mend4dReport> mendMesh4d(formats::Mesh4d& mesh, const Mend4dOptions& options = {});

}  // namespace t4d::edit
