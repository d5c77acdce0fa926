#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/edit.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

class Members;

struct ResolveOptions {
  edit::ResolveOptions mesh = {};
  std::vector<std::string> change = {};  ///< names of the bodies that give way; none for all
  bool ignoreUnits = false;              ///< take numbers as they are where units differ
  std::string output = {};               ///< the .t4d to write, with all bodies; "" for none
  int compression = 3;                   ///< as formats::T4dWriteOptions::compression
  std::string generator = {};            ///< program and version, for the metadata
};

/// A body that gave way, or was clear already.
struct NamedResolvedBody : edit::ResolvedBody {
  std::string name;
};

struct ResolveReport {
  std::vector<NamedResolvedBody> bodies;  ///< valid as long as the input
  edit::ResolveReport all;                ///< of all of them together, without layers
  /// How far the mesh of a body and that of an obstacle are from their motions, together; nothing
  /// if that is not known of some.
  std::optional<double> chordBound = {};
  /// The clearance that makes it certain that the motions do not meet either; nothing if it is.
  std::optional<double> decidingClearance = {};
  std::optional<std::uint64_t> bytes = {};  ///< of `output`
  std::vector<std::string> notices = {};    ///< on bodies that never exist with an obstacle
  std::vector<std::string> losses = {};
};

/// Deforms bodies of `input` so that they keep a distance from those of `obstacles`
/// (edit::resolve), and writes the file. Fails for two inputs with different units or up axes,
/// unless they are ignored, and as edit::resolve does.
Result<ResolveReport> resolve(const Input& obstacles, const Input& input,
                              const ResolveOptions& options = {}, Observer& observer = nobody());

void describe(Members& members, const ResolveReport& report);

}  // namespace t4d::tools
