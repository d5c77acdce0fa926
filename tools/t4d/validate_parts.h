#pragma once

#include <nlohmann/json.hpp>

#include "measure/mesh_parts.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "tools/t4d/validation.h"

/// Validating a file in parts, each by another process. A part reads its slabs and the one before
/// them, checks the layer between, and reports sums without rounding; the first part also checks
/// every byte of the file. All parts together find what `validate` finds.
namespace t4d::tools {

struct PartValidation {
  struct Body {
    std::string name;
    measure::PartOfMesh part;
    formats::BodySummary said;  ///< in the file, of the whole body
  };
  /// The bodies as far as the file can be read.
  std::vector<Body> bodies;
  std::optional<measure::Issue> damage;  ///< why there are no more bodies
  bool beforeAll = false;                ///< the damage was found before any slab was read
};

/// Fails (Options) if there are more parts than slabs, and as `validate` does.
Result<PartValidation> validatePart(const std::filesystem::path& path,
                                    const measure::CheckOptions& options, const model::Part& part,
                                    const model::Progress& progress = {},
                                    std::optional<std::uint64_t> maxCells = {});

/// The findings of one part.
Validation validationOf(const PartValidation& part);
/// The findings of all parts, in order.
Result<Validation> joinedValidation(const std::vector<PartValidation>& parts);

/// A part without loss, and back; nothing if that is not such a part.
nlohmann::ordered_json stateOf(const PartValidation& part);
std::optional<PartValidation> partValidationOf(const nlohmann::ordered_json& state);

}  // namespace t4d::tools
