#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "measure/visit_fields.h"
#include "t4d/mesh.h"
#include "tools/t4d/envelope.h"

namespace t4d::tools {

/// The points of the fields of one run.
struct VisitFieldWork {
  measure::SpaceLattice lattice;  ///< of all parts
  model::Part part = {};
  /// The data that tells the parts of this run from others; empty for the whole fields.
  std::map<std::string, std::string> run = {};
  /// Puts the motion into a sink.
  std::function<Result<void>(model::Sink&)> put = {};
};

/// Fails if the fields of a part need more memory than that, in bytes, with
/// Remedy::VoxelSizeOrParts, and for voxels that no .vdb has.
Result<void> checkFields(const measure::SpaceLattice& lattice, const model::Part& part,
                         double memory);

/// Writes the fields that are asked for. For a part, only its points are worked on.
Result<std::vector<WrittenField>> writeVisitFields(const VisitFieldFiles& files,
                                                   const VisitFieldWork& work,
                                                   Observer& observer = nobody());

}  // namespace t4d::tools
