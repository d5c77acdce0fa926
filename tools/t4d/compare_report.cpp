#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "tools/t4d/compare.h"
#include "tools/t4d/csv_field.h"
#include "tools/t4d/members.h"

namespace t4d::tools {
namespace {

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

void describeQuantiles(Members& members, const CellQuantiles& quantiles) {
  members("p01", quantiles.p01, "The value that 1 % of the cells do not exceed; null if infinite.")
      .orNull();
  members("p50", quantiles.p50, "The value that 50 % of the cells do not exceed; null if infinite.")
      .orNull();
  members("p99", quantiles.p99, "The value that 99 % of the cells do not exceed; null if infinite.")
      .orNull();
}

void describeMesh(Members& members, const ComparedMesh& mesh) {
  members("name", mesh.name, "The method, or the name of the file and its backend.");
  members("backend", mesh.backend, "mesh4d, voxel4d or another word; empty if the file has none.");
  members("vertices", mesh.vertices, "Vertices, each counted once.");
  members("tetrahedra", mesh.tetrahedra, "Cells.");
  members("bytes", mesh.bytes, "Size of the file, in bytes.");
  members("seconds", mesh.seconds, "Time to make the mesh, in seconds; null for an existing file.")
      .atLeast(0);
  members("peak_bytes", mesh.peakBytes,
          "Peak memory to make the mesh, in bytes; null for an existing file.");
  members("hypervolume", mesh.hypervolume,
          "Enclosed hypervolume, in cubed length units times time units.")
      .orNull();
  members("quality", mesh.shapes, "The shape of the cells, as `t4d quality` measures it.",
          [](Members& own, const CellShapes& shapes) {
            own("time_scale", shapes.timeScale,
                "The length that one unit of time counts as: the mean normal speed of a.")
                .above(0);
            own("radius_ratio", shapes.radiusRatio,
                "Circumradius divided by three inradii; 1 for a regular cell.", describeQuantiles);
            own("smallest_angle", shapes.smallestAngle, "In degrees.", describeQuantiles);
          });
  members
      .ifKnown("hypervolume_expected", mesh.hypervolumeExpected,
               "Hypervolume of the true moving solid. Only for one solid and both backends.")
      .atLeast(0)
      .orNull();
  members
      .ifKnown("hypervolume_error", mesh.hypervolumeError(),
               "A fraction: (hypervolume - hypervolume_expected) / hypervolume_expected.")
      .orNull();
  members
      .ifKnown("voxel_size", mesh.voxelSize,
               "Voxel size, in length units. Only of voxel4d for one solid.")
      .above(0);
  members.ifKnown("frames", mesh.frames, "Number of frames. Only of voxel4d for one solid.")
      .atLeast(2);
}

/// Adds what a slice says besides its time.
void addComparedSlice(Members& members, const ComparedSlice& slice) {
  members("volume_a", slice.volumeA,
          "Volume of solid a, in cubed length units; 0 if it does not exist at this time.")
      .orNull();
  members("volume_b", slice.volumeB,
          "Volume of solid b, in cubed length units; 0 if it does not exist at this time.")
      .orNull();
  members("area_a", slice.areaA,
          "Area of the surface of a, in squared length units; 0 if it does not exist at this time.")
      .atLeast(0)
      .orNull();
  members("area_b", slice.areaB,
          "Area of the surface of b, in squared length units; 0 if it does not exist at this time.")
      .atLeast(0)
      .orNull();
  members("symmetric_difference", slice.difference.volume,
          "Volume that is in one solid but not in the other, in cubed length units, to about four "
          "digits.")
      .atLeast(0)
      .orNull();
  members("hausdorff", slice.distance.hausdorff(),
          "Largest distance from a point of one surface to the other surface, in length units. It "
          "may be too small by a thousandth of the solids' diagonal. Also null if only one solid "
          "exists.")
      .atLeast(0)
      .orNull();
  members("hausdorff_95", slice.surfaces.hausdorff95,
          "The larger of two distances, within which 95 % of the surface of one solid is from that "
          "of the other, in length units. Also null if only one solid exists.")
      .atLeast(0)
      .orNull();
  members("mean_distance", slice.surfaces.meanDistance,
          "Mean distance of the points of each surface from the other, over the area of both, in "
          "length units. Also null if only one solid exists.")
      .atLeast(0)
      .orNull();
  members("volume_difference", slice.volumeDifference(),
          "volume_b - volume_a, in cubed length units.")
      .orNull();
  members("dice", slice.dice(),
          "Twice the volume of both as a part of the sum of their volumes. Also null if neither "
          "exists.")
      .atMost(1);
  members("jaccard", slice.jaccard(),
          "The volume of both as a part of that of either. Also null if neither exists.")
      .atMost(1);
}

struct NamedSlice {
  std::string name;  ///< of a body
  ComparedSlice slice;
};
struct SlicesAtTime {
  ComparedSlice all;
  std::vector<NamedSlice> bodies;
};

std::vector<SlicesAtTime> slicesOf(const Comparison& comparison) {
  std::vector<SlicesAtTime> slices;
  for (std::size_t i = 0; i < comparison.slices.size(); ++i) {
    slices.push_back({comparison.slices[i], {}});
    for (const ComparedBody& body : comparison.bodies) {
      slices.back().bodies.push_back({body.name, body.slices[i]});
    }
  }
  return slices;
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

void describeConvergence(Members& members, const std::vector<Comparison>& comparisons) {
  members("levels", comparisons,
          "The meshes of voxel4d for each voxel size, from the largest to the smallest.",
          [](Members& own, const Comparison& comparison) {
            describeMesh(own, comparison.b);
            own("symmetric_difference", comparison.meanDifference(),
                "The difference from a, of all slices together, as a fraction of the volumes of a.")
                .atLeast(0);
            own("hausdorff", comparison.largestHausdorff(),
                "The largest of all slices, in length units.")
                .atLeast(0)
                .orNull();
          })
      .itemsFrom(2);
  constexpr const char* kOrder =
      "Slope of the least-squares line through the logarithms of error and voxel size; null if "
      "there are fewer than two errors above rounding.";
  const ConvergenceOrders orders = ordersOf(comparisons);
  members("order_hypervolume", orders.hypervolume, kOrder);
  members("order_symmetric_difference", orders.difference, kOrder);
  members("order_hausdorff", orders.hausdorff, kOrder);
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

void describe(Members& members, const CompareReport& report) {
  static const Comparison kNone;
  const Comparison& comparison = report.comparisons.empty() ? kNone : report.comparisons.back();
  members("length_unit", report.lengthUnit,
          "Length unit of a, or of b if a has none; empty if neither has one.");
  members("time_unit", report.timeUnit,
          "Time unit of a, or of b if a has none; empty if neither has one.");
  members("a", comparison.a, "One of the meshes, with all its bodies together.", describeMesh);
  members("b", comparison.b, "The other mesh.", describeMesh);
  members("slices", slicesOf(comparison),
          "Both solids at each of the requested times, in that order.",
          [](Members& own, const SlicesAtTime& at) {
            own("time", at.all.time, "In time units.");
            addComparedSlice(own, at.all);
            own("bodies", at.bodies, "With --each-body: each body with that of the same name.",
                [](Members& ofBody, const NamedSlice& body) {
                  ofBody("name", body.name, "The name of the body.");
                  addComparedSlice(ofBody, body.slice);
                })
                .itemsFrom(1)
                .onlyIf(!at.bodies.empty());
          })
      .itemsFrom(1);
  members("convergence", report.comparisons, "Only for several voxel sizes.", describeConvergence)
      .onlyIf(report.comparisons.size() > 1);
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

}  // namespace t4d::tools
