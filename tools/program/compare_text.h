#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tools/program/compare_page.h"

namespace t4d::tools {

/// Prints the tables for people; for several voxel sizes, only the convergence table.
void printText(const CompareReport& report);

/// The report for programs; docs/schemas/compare.schema.json describes it.
nlohmann::ordered_json compareJson(const CompareReport& report);

/// A heading and a row for each time of each comparison; an undefined Hausdorff distance is left
/// empty. Numbers are in the shortest form that reads back as the same double.
std::string compareCsv(const CompareReport& report);

}  // namespace t4d::tools
