#include "tools/t4d/conform_page.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

using conformance::CaseResult;
using conformance::Check;
using conformance::Level;

std::string orderCell(const std::optional<double>& order) {
  return order ? fmt::format("{:.2f}", *order) : "";
}

/// A relative error in percent, if it is more than rounding.
std::string errorText(const std::optional<double>& error) {
  constexpr double kRounding = 1e-12;
  if (!error) return "";
  return *error < kRounding ? fmt::format("< {:g}", kRounding)
                            : fmt::format("{:.2f} %", 100 * *error);
}

/// A plot for each case that was refined, all with the same y axis.
std::vector<Plot> convergenceOf(std::span<const CaseResult> results) {
  std::vector<Plot> plots;
  std::vector<double> all;
  for (const CaseResult& result : results) {
    if (result.levels.size() < 2) continue;
    std::vector<double> sizes;
    std::vector<Curve> errors = {{"hypervolume", "a", {}}, {"slices' volumes", "b", {}}};
    for (const Level& level : result.levels) {
      sizes.push_back(level.resolution.voxelSize);
      errors[0].values.push_back(level.hypervolumeError.value_or(0));
      errors[1].values.push_back(level.sliceError.value_or(0));
    }
    plots.push_back(convergencePlot(result.id + ": errors [%]", "voxel size", std::move(sizes),
                                    std::move(errors)));
    for (const Curve& curve : plots.back().curves) {
      all.insert(all.end(), curve.values.begin(), curve.values.end());
    }
  }
  for (Plot& plot : plots) plot.covers = all;
  return plots;
}

std::string checksOf(const CaseResult& result) {
  Table rows = {{"check", "expected", "found", "may differ by", "because"}};
  for (const Check& check : result.checks) {
    rows.push_back({(check.passed ? "" : "FAILED ") + check.name, valueText(check.expected, 12),
                    valueText(check.actual, 12),
                    check.tolerance > 0 ? fmt::format("{:.2g}", check.tolerance) : "",
                    check.reason + (check.found.empty() ? "" : "; found: " + check.found)});
  }
  return fmt::format(
      "<details{}><summary>{} by {}: {} of {} checks passed</summary>\n{}</details>\n",
      result.passed() ? "" : " open", escaped(result.id), escaped(result.backend),
      result.passedChecks(), result.checks.size(), tableOf(rows));
}

}  // namespace

std::vector<std::string> conformColumns() {
  return {"case",        "backend", "checks",        "hypervolume", "expected",
          "worst error", "order",   "order, slices", "time"};
}

std::vector<std::string> conformRow(const CaseResult& result) {
  const bool built = !result.levels.empty();
  return {result.id,
          result.backend,
          fmt::format("{}{}/{}", result.passed() ? "" : "FAILED ", result.passedChecks(),
                      result.checks.size()),
          built ? fmt::format("{:.8g}", result.levels.back().mesh.hypervolume) : "",
          result.hypervolumeExpected ? fmt::format("{:.8g}", *result.hypervolumeExpected) : "",
          errorText(result.worstError),
          orderCell(result.orders.hypervolume),
          orderCell(result.orders.slices),
          fmt::format("{:.1f} s", result.seconds)};
}

std::string valueText(const conformance::Value& value, int digits) {
  if (const bool* truth = std::get_if<bool>(&value)) return *truth ? "yes" : "no";
  if (const auto* count = std::get_if<std::uint64_t>(&value)) return grouped(*count);
  return fmt::format("{:.{}g}", std::get<double>(value), digits);
}

std::string conformPage(std::span<const CaseResult> results) {
  const auto passed = std::count_if(results.begin(), results.end(),
                                    [](const CaseResult& result) { return result.passed(); });
  std::size_t checks = 0;
  Table rows = {conformColumns()};
  std::string details;
  for (const CaseResult& result : results) {
    checks += result.checks.size();
    rows.push_back(conformRow(result));
    details += checksOf(result);
  }
  std::string html =
      paragraphOf(fmt::format(
          "{} of {} cases passed, {} checks in all. Each case is a moving solid whose hypervolume, "
          "slices, topology and extent are known in closed form. The worst error is the largest "
          "relative error of any volume, at the smallest voxel size.",
          passed, results.size(), grouped(checks))) +
      tableOf(rows);
  if (const std::vector<Plot> plots = convergenceOf(results); !plots.empty()) {
    html += headingOf("Convergence") +
            paragraphOf(
                "Error of the hypervolume and of the slices' volumes (root mean square) by voxel "
                "size; both axes are logarithmic. Dashed: order 2.") +
            plotsOf(plots);
  }
  return htmlPage("t4d conform backends", html + headingOf("Every check") + details);
}

}  // namespace t4d::tools
