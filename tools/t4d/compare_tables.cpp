#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tools/t4d/compare_page.h"
#include "tools/t4d/console.h"

namespace t4d::tools {
namespace {

std::string numberText(double value) { return fmt::format("{:.9g}", value); }

/// "+1.23 %"; rounding counts as none.
std::string percentText(double fraction) {
  constexpr double kRounding = 1e-12;
  return std::abs(fraction) < kRounding ? "0 %" : fmt::format("{:+.3g} %", 100 * fraction);
}

std::string orderText(const std::optional<double>& order) {
  return order ? fmt::format("{:.2f}", *order) : "";
}

/// The label of hypervolumes, with the unit "mm³ s", if both are known.
std::string hypervolumeLabel(const CompareReport& report) {
  const bool known = !report.lengthUnit.empty() && !report.timeUnit.empty();
  return labelled("hypervolume",
                  known ? fmt::format("{}³ {}", report.lengthUnit, report.timeUnit) : "");
}

}  // namespace

Table meshTable(const CompareReport& report, const Comparison& comparison) {
  const ComparedMesh& a = comparison.a;
  const ComparedMesh& b = comparison.b;
  const auto ratio = [](double ofA, double ofB) {
    return ofA > 0 ? fmt::format("{:.3g}", ofB / ofA) : std::string();
  };
  const auto orUnknown = [](const std::string& text) { return text.empty() ? "-" : text; };
  Table rows = {{"", "a: " + a.name, "b: " + b.name, "b / a"},
                {"backend", orUnknown(a.backend), orUnknown(b.backend), ""}};
  const auto count = [&](const char* label, std::uint64_t ofA, std::uint64_t ofB) {
    rows.push_back({label, grouped(ofA), grouped(ofB),
                    ratio(static_cast<double>(ofA), static_cast<double>(ofB))});
  };
  count("vertices", a.vertices, b.vertices);
  count("tetrahedra", a.tetrahedra, b.tetrahedra);
  rows.push_back({"size of the file", sizeText(a.bytes), sizeText(b.bytes),
                  ratio(static_cast<double>(a.bytes), static_cast<double>(b.bytes))});
  if (a.seconds && b.seconds) {
    rows.push_back({"construction", fmt::format("{:.3f} s", *a.seconds),
                    fmt::format("{:.3f} s", *b.seconds), ratio(*a.seconds, *b.seconds)});
  }
  if (a.peakBytes && b.peakBytes) {
    rows.push_back({"peak memory", sizeText(*a.peakBytes), sizeText(*b.peakBytes),
                    ratio(static_cast<double>(*a.peakBytes), static_cast<double>(*b.peakBytes))});
  }
  rows.push_back({hypervolumeLabel(report), numberText(a.hypervolume), numberText(b.hypervolume),
                  ratio(a.hypervolume, b.hypervolume)});
  if (a.hypervolumeExpected && b.hypervolumeExpected) {
    rows.push_back({"  of the true solid", numberText(*a.hypervolumeExpected),
                    numberText(*b.hypervolumeExpected), ""});
  }
  if (a.hypervolumeError() && b.hypervolumeError()) {
    rows.push_back(
        {"  error", percentText(*a.hypervolumeError()), percentText(*b.hypervolumeError()), ""});
  }
  const auto quantiles = [&](const char* label, CellQuantiles CellShapes::*of) {
    const auto text = [&](const ComparedMesh& mesh) {
      const CellQuantiles& all = mesh.shapes.*of;
      return fmt::format("{:.3g}, {:.3g}, {:.3g}", all.p01, all.p50, all.p99);
    };
    rows.push_back({label, text(a), text(b), ""});
  };
  quantiles("radius ratio, 1, 50, 99 %", &CellShapes::radiusRatio);
  quantiles("smallest angle, 1, 50, 99 %", &CellShapes::smallestAngle);
  return rows;
}

Table sliceTable(const CompareReport& report, const Comparison& comparison) {
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  Table rows = {{labelled("time", report.timeUnit), labelled("volume a", report.lengthUnit, "³"),
                 "volume b", labelled("area a", report.lengthUnit, "²"), "area b",
                 "sym. difference", "of a", "Dice", labelled("Hausdorff", report.lengthUnit),
                 "95 %", "mean"}};
  const bool several = !comparison.bodies.empty();
  if (several) rows[0].insert(rows[0].begin() + 1, "body");
  const auto add = [&](const ComparedSlice& slice, const std::string& body) {
    const double difference = slice.difference.volume;
    const auto distance = [&](double length) {
      return std::isfinite(length) ? number(length) : std::string("-");
    };
    rows.push_back(
        {number(slice.time), number(slice.volumeA), number(slice.volumeB), number(slice.areaA),
         number(slice.areaB), number(difference),
         slice.volumeA > 0 ? fmt::format("{:.3g} %", 100 * difference / slice.volumeA) : "-",
         slice.dice() ? fmt::format("{:.4f}", *slice.dice()) : "-",
         distance(slice.distance.hausdorff()), distance(slice.surfaces.hausdorff95),
         distance(slice.surfaces.meanDistance)});
    if (several) rows.back().insert(rows.back().begin() + 1, body);
  };
  for (std::size_t i = 0; i < comparison.slices.size(); ++i) {
    if (!several) add(comparison.slices[i], "");
    for (const ComparedBody& body : comparison.bodies) add(body.slices[i], shownLine(body.name));
  }
  return rows;
}

Table convergenceTable(const CompareReport& report) {
  Table rows = {{"", labelled("voxel size", report.lengthUnit), "frames", "tetrahedra", "file",
                 "construction", "peak memory", "hypervolume error", "sym. difference",
                 labelled("Hausdorff", report.lengthUnit)}};
  const auto row = [&](const ComparedMesh& mesh, std::string label, std::string difference,
                       std::string hausdorff) {
    rows.push_back({std::move(label), mesh.voxelSize ? fmt::format("{}", *mesh.voxelSize) : "",
                    mesh.frames ? grouped(*mesh.frames) : "", grouped(mesh.tetrahedra),
                    sizeText(mesh.bytes),
                    mesh.seconds ? fmt::format("{:.3f} s", *mesh.seconds) : "",
                    mesh.peakBytes ? sizeText(*mesh.peakBytes) : "",
                    mesh.hypervolumeError() ? percentText(*mesh.hypervolumeError()) : "",
                    std::move(difference), std::move(hausdorff)});
  };
  row(report.comparisons.front().a, "mesh method", "", "");
  for (const Comparison& comparison : report.comparisons) {
    const auto difference = comparison.meanDifference();
    row(comparison.b, "voxel method", difference ? fmt::format("{:.3g} %", 100 * *difference) : "",
        fmt::format("{:.3g}", comparison.largestHausdorff()));
  }
  const ConvergenceOrders orders = ordersOf(report.comparisons);
  rows.push_back({"order of convergence", "", "", "", "", "", "", orderText(orders.hypervolume),
                  orderText(orders.difference), orderText(orders.hausdorff)});
  return rows;
}

}  // namespace t4d::tools
