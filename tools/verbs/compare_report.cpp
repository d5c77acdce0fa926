#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/verbs/compare.h"
#include "tools/verbs/csv_field.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

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

/// The slice as JSON, without its time.
ordered_json jsonOf(const ComparedSlice& slice) {
  const auto distance = [](double length) {
    return std::isfinite(length) ? ordered_json(length) : ordered_json();
  };
  return {{"volume_a", slice.volumeA},
          {"volume_b", slice.volumeB},
          {"area_a", slice.areaA},
          {"area_b", slice.areaB},
          {"symmetric_difference", slice.difference.volume},
          {"hausdorff", distance(slice.distance.hausdorff())},
          {"hausdorff_95", distance(slice.surfaces.hausdorff95)},
          {"mean_distance", distance(slice.surfaces.meanDistance)},
          {"volume_difference", slice.volumeDifference()},
          {"dice", orNull(slice.dice())},
          {"jaccard", orNull(slice.jaccard())}};
}

ordered_json slicesJson(const Comparison& comparison) {
  ordered_json value = ordered_json::array();
  for (std::size_t i = 0; i < comparison.slices.size(); ++i) {
    ordered_json slice = {{"time", comparison.slices[i].time}};
    slice.update(jsonOf(comparison.slices[i]));
    for (const ComparedBody& body : comparison.bodies) {
      ordered_json one = {{"name", body.name}};
      one.update(jsonOf(body.slices[i]));
      slice["bodies"].push_back(std::move(one));
    }
    value.push_back(std::move(slice));
  }
  return value;
}

/// A row of the table; `body` is a field with its comma.
std::string rowOf(const ComparedSlice& slice, const std::string& body) {
  const auto number = [](const std::optional<double>& value) {
    return value && std::isfinite(*value) ? fmt::format("{}", *value) : std::string();
  };
  return fmt::format("{},{}{},{},{},{},{},{},{},{},{},{},{}\n", slice.time, body, slice.volumeA,
                     slice.volumeB, slice.areaA, slice.areaB, slice.difference.volume,
                     number(slice.distance.hausdorff()), number(slice.surfaces.hausdorff95),
                     number(slice.surfaces.meanDistance), slice.volumeDifference(),
                     number(slice.dice()), number(slice.jaccard()));
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

std::optional<double> ComparedSlice::dice() const {
  const double both = volumeA + volumeB;
  if (!(both > 0)) return std::nullopt;
  if (volumeA == 0 || volumeB == 0) return 0;  // and not the error of the difference
  return 1 - difference.volume / both;
}

std::optional<double> ComparedSlice::jaccard() const {
  const double both = volumeA + volumeB;
  if (!(both > 0)) return std::nullopt;
  if (volumeA == 0 || volumeB == 0) return 0;
  return (both - difference.volume) / (both + difference.volume);
}

std::optional<double> Comparison::meanDifference() const {
  double difference = 0;
  double volume = 0;
  for (const ComparedSlice& slice : slices) {
    difference += slice.difference.volume;
    volume += slice.volumeA;
  }
  if (!(volume > 0)) return std::nullopt;
  return difference / volume;
}

double Comparison::largestHausdorff() const {
  double largest = 0;
  for (const ComparedSlice& slice : slices) {
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
                        {"slices", slicesJson(comparison)}};
  if (report.comparisons.size() > 1) value["convergence"] = convergenceJson(report);
  return jsonText(value);
}

std::string csvOf(const CompareReport& report) {
  const bool voxels = report.comparisons.front().b.voxelSize.has_value();
  std::string csv = voxels ? "voxel_size,frames," : "";
  const bool several = !report.comparisons.front().bodies.empty();
  csv += fmt::format(
      "time,{}volume_a,volume_b,area_a,area_b,symmetric_difference,hausdorff,hausdorff_95,"
      "mean_distance,volume_difference,dice,jaccard\n",
      several ? "body," : "");
  for (const Comparison& comparison : report.comparisons) {
    const std::string before =
        voxels ? fmt::format("{},{},", *comparison.b.voxelSize, comparison.b.frames.value_or(0))
               : "";
    for (std::size_t i = 0; i < comparison.slices.size(); ++i) {
      if (!several) csv += before + rowOf(comparison.slices[i], "");
      for (const ComparedBody& body : comparison.bodies) {
        csv += before + rowOf(body.slices[i], csvField(body.name) + ",");
      }
    }
  }
  return csv;
}

}  // namespace t4d::verbs
