#pragma once

#include <span>
#include <string>
#include <vector>

#include "t4d/conformance.h"

namespace t4d::tools {

/// The table of the cases: its columns, of which the first two are text, and a row for each case.
/// Shared by page and terminal.
std::vector<std::string> conformColumns();
std::vector<std::string> conformRow(const conformance::CaseResult& result);

/// A value as text: "yes", "no", or a number with at most `digits` digits.
std::string valueText(const conformance::Value& value, int digits = 9);

/// One self-contained HTML page: the table, a convergence plot for each voxel case, and every
/// check.
std::string conformPage(std::span<const conformance::CaseResult> results);

}  // namespace t4d::tools
