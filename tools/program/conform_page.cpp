#include "tools/program/conform_page.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "tools/program/console.h"
#include "tools/report/convergence_plot.h"
#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

using conformance::CaseResult;
using conformance::Check;
using conformance::Level;

constexpr std::string_view kConformStyle = R"(
td:nth-child(2), th:nth-child(2) { text-align: left; }
.failed { color: #c4314b; font-weight: 600; }
.order { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.5; }
.convergence { display: grid; grid-template-columns: repeat(auto-fill, minmax(250px, 1fr)); gap: 16px;
  align-items: start; }
.convergence svg { width: 100%; background: var(--card); border-radius: 8px; }
details { margin: 0 0 6px; }
summary { cursor: pointer; }
.checks td, .checks th { text-align: left; font-size: 13px; padding: 3px 16px 3px 0; }
.checks td:nth-child(n+2):nth-child(-n+4), .checks th:nth-child(n+2):nth-child(-n+4) {
  text-align: right; }
)";

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

/// One plot per case that was refined, all to the same scale.
std::string plotsOf(std::span<const CaseResult> results) {
  std::vector<ConvergencePlot> plots;
  std::pair<double, double> sizes = {std::numeric_limits<double>::infinity(), 0};
  std::pair<double, double> errors = sizes;
  const auto widen = [](std::pair<double, double>& range, double value) {
    range = {std::min(range.first, value), std::max(range.second, value)};
  };
  for (const CaseResult& result : results) {
    if (result.levels.size() < 2) continue;
    ConvergencePlot plot{
        result.id, "voxel size", {{"hypervolume", "a", {}}, {"slices' volumes", "b", {}}},
        2,         {},           {}};
    for (const Level& level : result.levels) {
      const double size = level.resolution.voxelSize;
      const auto add = [&](ErrorCurve& curve, const std::optional<double>& error) {
        if (!error || !(*error > 0)) return;
        curve.points.emplace_back(size, *error);
        widen(sizes, size);
        widen(errors, *error);
      };
      add(plot.curves[0], level.hypervolumeError);
      add(plot.curves[1], level.sliceError);
    }
    plots.push_back(std::move(plot));
  }
  if (!(errors.second > 0)) return {};
  std::string html;
  for (ConvergencePlot& plot : plots) {
    plot.sizes = sizes;
    plot.errors = errors;
    html += svgOf(plot);
  }
  return html;
}

std::string checksOf(const CaseResult& result) {
  std::string html = fmt::format(
      "<details{}><summary>{} by {}: {} of {} checks passed</summary>\n<div "
      "class=\"scroll\"><table "
      "class=\"checks\">\n<tr><th>check</th><th>expected</th><th>found</th><th>may differ by</th>"
      "<th>because</th></tr>\n",
      result.passed() ? "" : " open", escaped(result.id), escaped(result.backend),
      result.passedChecks(), result.checks.size());
  for (const Check& check : result.checks) {
    html += fmt::format("<tr{}><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}{}</td></tr>\n",
                        check.passed ? "" : " class=\"failed\"", escaped(check.name),
                        valueText(check.expected, 12), valueText(check.actual, 12),
                        check.tolerance > 0 ? fmt::format("{:.2g}", check.tolerance) : "",
                        escaped(check.reason),
                        check.found.empty() ? "" : "; found: " + escaped(check.found));
  }
  return html + "</table></div></details>\n";
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
  for (const CaseResult& result : results) checks += result.checks.size();
  std::string html = fmt::format(
      "<p>{} of {} cases passed, {} checks in all. Each case is a moving solid whose hypervolume, "
      "slices, topology and extent are known in closed form. The worst error is the largest "
      "relative error of any volume, at the smallest voxel size.</p>\n<div "
      "class=\"scroll\"><table>\n<tr>",
      passed, results.size(), grouped(checks));
  for (const std::string& column : conformColumns()) {
    html += fmt::format("<th>{}</th>", escaped(column));
  }
  html += "</tr>\n";
  std::string details;
  for (const CaseResult& result : results) {
    html += result.passed() ? "<tr>" : "<tr class=\"failed\">";
    for (const std::string& cell : conformRow(result)) {
      html += fmt::format("<td>{}</td>", escaped(cell));
    }
    html += "</tr>\n";
    details += checksOf(result);
  }
  html += "</table></div>\n";
  if (const std::string plots = plotsOf(results); !plots.empty()) {
    html +=
        "<h2>Convergence</h2>\n<p>Error of the <span class=\"key a\">hypervolume</span> and of the "
        "<span class=\"key b\">slices' volumes</span> (root mean square) by voxel size; "
        "both axes are logarithmic. Dashed: order 2.</p>\n<div class=\"convergence\">\n" +
        plots + "</div>\n";
  }
  html += "<h2>Every check</h2>\n" + details;
  return htmlPage("t4d conform backends", kConformStyle, html);
}

}  // namespace t4d::tools
