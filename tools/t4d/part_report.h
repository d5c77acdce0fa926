#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

/// Reports on parts of a run say what they must hold, so that `join` takes none that was changed.
namespace t4d::tools {

/// Adds `checksums` to the member `part` of a report: the CRC-32C of each member of the report.
void addChecksums(nlohmann::ordered_json& report);

/// The first member that is not what its checksum says, or has none, or has one and is missing;
/// nothing if the report is as it was written. Throws nlohmann::json::exception if there are no
/// checksums.
std::optional<std::string> alteredMember(const nlohmann::ordered_json& report);

}  // namespace t4d::tools
