#include "tools/t4d/compare_page.h"

#include <limits>

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/report/svg_plot.h"
#include "tools/t4d/pair_pictures.h"

namespace t4d::tools {
namespace {

/// A mesh in a legend: its name if that is short enough.
std::string shortName(const ComparedMesh& mesh, const char* letter) {
  constexpr std::size_t kShort = 16;
  const std::string name = mesh.name.substr(0, mesh.name.find(','));
  return name.size() <= kShort ? fmt::format("{}: {}", letter, name) : letter;
}

std::vector<Plot> plotsOverTime(const CompareReport& report, const Comparison& comparison) {
  Plot volume{labelled("Volume", report.lengthUnit, "³"),
              labelled("time", report.timeUnit),
              {},
              {{shortName(comparison.a, "a"), "a", {}}, {shortName(comparison.b, "b"), "b", {}}}};
  Plot area = volume;
  area.title = labelled("Area", report.lengthUnit, "²");
  Plot difference = volume;
  difference.title = labelled("Symmetric difference", report.lengthUnit, "³");
  difference.curves = {{"symmetric difference", "d", {}}};
  difference.covers = {0.0};
  Plot distance = volume;
  distance.title = labelled("Distance of the surfaces", report.lengthUnit);
  distance.curves = {{"largest", "a", {}}, {"of 95 %", "b", {}}, {"mean", "d", {}}};
  distance.covers = {0.0};
  Plot overlap = volume;
  overlap.title = "Overlap";
  overlap.curves = {{"Dice", "a", {}}, {"Jaccard", "b", {}}};
  overlap.covers = {1.0};
  if (comparison.volumeExpected) {
    volume.curves.push_back(
        {"true solid", "dashed",
         std::vector<double>(comparison.slices.size(), *comparison.volumeExpected)});
  }
  for (const ComparedSlice& slice : comparison.slices) {
    for (Plot* plot : {&volume, &area, &difference, &overlap, &distance}) {
      plot->x.push_back(slice.time);
    }
    volume.curves[0].values.push_back(slice.volumeA);
    volume.curves[1].values.push_back(slice.volumeB);
    area.curves[0].values.push_back(slice.areaA);
    area.curves[1].values.push_back(slice.areaB);
    difference.curves[0].values.push_back(slice.difference.volume);
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    overlap.curves[0].values.push_back(slice.dice().value_or(kNone));
    overlap.curves[1].values.push_back(slice.jaccard().value_or(kNone));
    distance.curves[0].values.push_back(slice.distance.hausdorff());
    distance.curves[1].values.push_back(slice.surfaces.hausdorff95);
    distance.curves[2].values.push_back(slice.surfaces.meanDistance);
  }
  return {volume, area, difference, overlap, distance};
}

std::string convergenceOf(const CompareReport& report) {
  std::vector<double> sizes;
  std::vector<Curve> errors = {{"hypervolume", "b", {}}, {"symmetric difference", "d", {}}};
  for (const Comparison& comparison : report.comparisons) {
    if (!comparison.b.voxelSize) continue;
    sizes.push_back(*comparison.b.voxelSize);
    errors[0].values.push_back(comparison.b.hypervolumeError().value_or(0));
    errors[1].values.push_back(comparison.meanDifference().value_or(0));
  }
  return headingOf("Convergence") + tableOf(convergenceTable(report)) +
         paragraphOf(
             "Errors of the hypervolume, against the true solid, and of the symmetric difference "
             "from the mesh method, as a fraction of its volume, over the voxel size. Both axes "
             "are logarithmic; the dashed lines are of order 2. An order is the slope of the "
             "least-squares line. The rest of the page is for the smallest voxels.") +
         plotsOf({convergencePlot("Errors [%]", labelled("voxel size", report.lengthUnit),
                                  std::move(sizes), std::move(errors))});
}

}  // namespace

std::string comparePage(const std::string& title, const CompareReport& report) {
  const Comparison& comparison = report.comparisons.back();
  std::string html = fmt::format(
      "<p><span class=\"key a\">a</span> is {}, <span class=\"key b\">b</span> is {}.</p>\n",
      escaped(comparison.a.name), escaped(comparison.b.name));
  for (const std::string& note : report.notes) html += paragraphOf("Note: " + note + ".");
  if (report.comparisons.size() > 1) html += convergenceOf(report) + headingOf("The meshes");
  html += tableOf(meshTable(report, comparison)) + headingOf("Over time");
  if (comparison.volumeExpected) {
    html += paragraphOf(
        "The dashed line is the volume of the true solid, which does not change as it moves.");
  }
  const formats::Metadata metadata{
      .lengthUnit = report.lengthUnit, .timeUnit = report.timeUnit, .up = report.zUp ? "z" : "y"};
  html += plotsOf(plotsOverTime(report, comparison)) + headingOf("The solids") +
          pairPictures({comparison.a.name, comparison.b.name, comparison.largestHausdorff()},
                       metadata, report.pairs) +
          headingOf("In numbers") +
          paragraphOf(
              "The symmetric difference is the volume that lies in one solid and not in the other; "
              "the Hausdorff distance is how far the farthest point of one surface is from the "
              "other.") +
          tableOf(sliceTable(report, comparison));
  return htmlPage(title, html);
}

}  // namespace t4d::tools
