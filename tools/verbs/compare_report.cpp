#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/verbs/compare.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

using measure::SliceComparison;
using nlohmann::ordered_json;

/// The slope of the least-squares line through the points' logarithms; empty for fewer than two
/// different sizes.
std::optional<double> logarithmicSlope(const std::vector<std::pair<double, double>>& points) {
  double x = 0;
  double y = 0;
  for (const auto& [size, error] : points) {
    x += std::log(size) / static_cast<double>(points.size());
    y += std::log(error) / static_cast<double>(points.size());
  }
  double xx = 0;
  double xy = 0;
  for (const auto& [size, error] : points) {
    xx += (std::log(size) - x) * (std::log(size) - x);
    xy += (std::log(size) - x) * (std::log(error) - y);
  }
  if (!(xx > 0)) return std::nullopt;
  return xy / xx;
}

/// The errors that exceed rounding, over the voxel size.
template <class ErrorOf>
std::optional<double> orderBy(std::span<const Comparison> comparisons, ErrorOf errorOf) {
  constexpr double kRounding = 1e-12;
  std::vector<std::pair<double, double>> points;
  for (const Comparison& comparison : comparisons) {
    const std::optional<double> error = errorOf(comparison);
    if (!comparison.b.voxelSize || !error || !(std::abs(*error) > kRounding)) continue;
    points.emplace_back(*comparison.b.voxelSize, std::abs(*error));
  }
  return logarithmicSlope(points);
}

ordered_json jsonOf(const CellQuantiles& quantiles) {
  const auto number = [](double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json();
  };
  return {{"p01", number(quantiles.p01)},
          {"p50", number(quantiles.p50)},
          {"p99", number(quantiles.p99)}};
}

ordered_json jsonOf(const ComparedMesh& mesh) {
  ordered_json value = {{"name", mesh.name},
                        {"backend", mesh.backend},
                        {"vertices", mesh.vertices},
                        {"tetrahedra", mesh.tetrahedra},
                        {"bytes", mesh.bytes},
                        {"seconds", orNull(mesh.seconds)},
                        {"peak_bytes", orNull(mesh.peakBytes)},
                        {"hypervolume", mesh.hypervolume},
                        {"quality",
                         {{"time_scale", mesh.shapes.timeScale},
                          {"radius_ratio", jsonOf(mesh.shapes.radiusRatio)},
                          {"smallest_angle", jsonOf(mesh.shapes.smallestAngle)}}}};
  if (mesh.hypervolumeExpected) value["hypervolume_expected"] = *mesh.hypervolumeExpected;
  if (const auto error = mesh.hypervolumeError()) value["hypervolume_error"] = *error;
  if (mesh.voxelSize) value["voxel_size"] = *mesh.voxelSize;
  if (mesh.frames) value["frames"] = *mesh.frames;
  return value;
}

ordered_json jsonOf(const std::vector<SliceComparison>& slices) {
  ordered_json value = ordered_json::array();
  for (const SliceComparison& slice : slices) {
    const double hausdorff = slice.distance.hausdorff();
    value.push_back(
        {{"time", slice.time},
         {"volume_a", slice.volumeA},
         {"volume_b", slice.volumeB},
         {"area_a", slice.areaA},
         {"area_b", slice.areaB},
         {"symmetric_difference", slice.difference.volume},
         {"hausdorff", std::isfinite(hausdorff) ? ordered_json(hausdorff) : ordered_json()}});
  }
  return value;
}

ordered_json convergenceJson(const CompareReport& report) {
  ordered_json levels = ordered_json::array();
  for (const Comparison& comparison : report.comparisons) {
    ordered_json level = jsonOf(comparison.b);
    level["symmetric_difference"] = orNull(comparison.meanDifference());
    level["hausdorff"] = comparison.largestHausdorff();
    levels.push_back(std::move(level));
  }
  const ConvergenceOrders orders = ordersOf(report.comparisons);
  return {{"levels", std::move(levels)},
          {"order_hypervolume", orNull(orders.hypervolume)},
          {"order_symmetric_difference", orNull(orders.difference)},
          {"order_hausdorff", orNull(orders.hausdorff)}};
}

}  // namespace

std::optional<double> ComparedMesh::hypervolumeError() const {
  if (!hypervolumeExpected || *hypervolumeExpected == 0) return std::nullopt;
  return hypervolume / *hypervolumeExpected - 1;
}

std::optional<double> Comparison::meanDifference() const {
  double difference = 0;
  double volume = 0;
  for (const SliceComparison& slice : slices) {
    difference += slice.difference.volume;
    volume += slice.volumeA;
  }
  if (!(volume > 0)) return std::nullopt;
  return difference / volume;
}

double Comparison::largestHausdorff() const {
  double largest = 0;
  for (const SliceComparison& slice : slices) {
    const double distance = slice.distance.hausdorff();
    if (std::isfinite(distance)) largest = std::max(largest, distance);
  }
  return largest;
}

ConvergenceOrders ordersOf(std::span<const Comparison> comparisons) {
  return {orderBy(comparisons, [](const Comparison& c) { return c.b.hypervolumeError(); }),
          orderBy(comparisons, [](const Comparison& c) { return c.meanDifference(); }),
          orderBy(comparisons,
                  [](const Comparison& c) { return std::optional<double>(c.largestHausdorff()); })};
}

std::string jsonOf(const CompareReport& report) {
  const Comparison& comparison = report.comparisons.back();
  ordered_json value = {{"length_unit", report.lengthUnit},
                        {"time_unit", report.timeUnit},
                        {"a", jsonOf(comparison.a)},
                        {"b", jsonOf(comparison.b)},
                        {"slices", jsonOf(comparison.slices)}};
  if (report.comparisons.size() > 1) value["convergence"] = convergenceJson(report);
  return jsonText(value);
}

std::string csvOf(const CompareReport& report) {
  const bool voxels = report.comparisons.front().b.voxelSize.has_value();
  std::string csv = voxels ? "voxel_size,frames," : "";
  csv += "time,volume_a,volume_b,area_a,area_b,symmetric_difference,hausdorff\n";
  for (const Comparison& comparison : report.comparisons) {
    for (const SliceComparison& slice : comparison.slices) {
      if (voxels) {
        csv += fmt::format("{},{},", *comparison.b.voxelSize, comparison.b.frames.value_or(0));
      }
      const double hausdorff = slice.distance.hausdorff();
      csv += fmt::format("{},{},{},{},{},{},{}\n", slice.time, slice.volumeA, slice.volumeB,
                         slice.areaA, slice.areaB, slice.difference.volume,
                         std::isfinite(hausdorff) ? fmt::format("{}", hausdorff) : "");
    }
  }
  return csv;
}

}  // namespace t4d::verbs
