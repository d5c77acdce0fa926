#pragma once

#include <string>

#include "tools/report/html_page.h"
#include "tools/t4d/compare.h"

namespace t4d::tools {

/// One self-contained HTML page: tables, plots over time, the convergence for several voxel sizes,
/// and pictures of the solids, plain and coloured by the distance of one from the other.
std::string comparePage(const std::string& title, const CompareReport& report);

// Tables for page and terminal.

/// Compares the two meshes: a label, a, b, and the ratio of b to a where it is meaningful.
Table meshTable(const CompareReport& report, const Comparison& comparison);

/// One row per time.
Table sliceTable(const CompareReport& report, const Comparison& comparison);

/// A row for the mesh method, one per voxel size, and one with the orders of convergence.
Table convergenceTable(const CompareReport& report);

}  // namespace t4d::tools
