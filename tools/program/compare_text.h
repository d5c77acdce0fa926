#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tools/program/compare_page.h"

namespace t4d::tools {

/// Prints the tables for people: for several voxel sizes that of the convergence alone.
void printText(const CompareReport& report);

/// The report for machines; docs/schemas/compare.schema.json describes it.
nlohmann::ordered_json compareJson(const CompareReport& report);

/// A heading and a row for each time of each comparison; a Hausdorff distance that is not defined
/// is empty. Numbers are in the shortest form that is read back as the same double.
std::string compareCsv(const CompareReport& report);

}  // namespace t4d::tools
