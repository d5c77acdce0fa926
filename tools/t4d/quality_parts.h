#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

namespace t4d::tools {

/// The report of `quality` on all slabs from those on the parts, with the `worst` cells of all of
/// them. Throws nlohmann::json::exception for anything but such reports.
nlohmann::ordered_json joinedQuality(const std::vector<nlohmann::ordered_json>& reports,
                                     std::uint64_t worst);

}  // namespace t4d::tools
