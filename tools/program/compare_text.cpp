#include "tools/program/compare_text.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/verbs/json_text.h"
#include "tools/program/console.h"

namespace t4d::tools {
namespace {

using measure::SliceComparison;
using nlohmann::ordered_json;

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
                        {"seconds", verbs::orNull(mesh.seconds)},
                        {"peak_bytes", verbs::orNull(mesh.peakBytes)},
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
    level["symmetric_difference"] = verbs::orNull(comparison.meanDifference());
    level["hausdorff"] = comparison.largestHausdorff();
    levels.push_back(std::move(level));
  }
  const ConvergenceOrders orders = ordersOf(report.comparisons);
  return {{"levels", std::move(levels)},
          {"order_hypervolume", verbs::orNull(orders.hypervolume)},
          {"order_symmetric_difference", verbs::orNull(orders.difference)},
          {"order_hausdorff", verbs::orNull(orders.hausdorff)}};
}

}  // namespace

void printText(const CompareReport& report) {
  const Comparison& comparison = report.comparisons.back();
  print("{}\n\n", report.title);
  if (report.comparisons.size() > 1) {
    printTable(convergenceTable(report), "lr");
    return;
  }
  printTable(meshTable(report, comparison), "lr");
  print("\n");
  printTable(sliceTable(report, comparison), "r");
}

ordered_json compareJson(const CompareReport& report) {
  const Comparison& comparison = report.comparisons.back();
  ordered_json value = {{"length_unit", report.lengthUnit},
                        {"time_unit", report.timeUnit},
                        {"a", jsonOf(comparison.a)},
                        {"b", jsonOf(comparison.b)},
                        {"slices", jsonOf(comparison.slices)}};
  if (report.comparisons.size() > 1) value["convergence"] = convergenceJson(report);
  return value;
}

std::string compareCsv(const CompareReport& report) {
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

}  // namespace t4d::tools
