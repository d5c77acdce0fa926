#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/measure/compare.h"
#include "tools/program/pair_pictures.h"

namespace t4d::tools {

/// What 1, 50 and 99 per cent of the cells do not exceed.
struct CellQuantiles {
  double p01 = 0;
  double p50 = 0;
  double p99 = 0;
};

/// The shape of the cells of a mesh (measure::MeshQuality), all together.
struct CellShapes {
  double timeScale = 0;
  CellQuantiles radiusRatio;
  CellQuantiles smallestAngle;
};

/// One of the two 4D meshes.
struct ComparedMesh {
  std::string name;     ///< "mesh method", "voxel method, 0.5 mm", or a file's name and backend
  std::string backend;  ///< "" if the file does not say
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t bytes = 0;                    ///< of the file
  std::optional<double> voxelSize;            ///< if the voxel method made it for this comparison
  std::optional<std::uint64_t> frames;        ///< likewise
  std::optional<double> seconds;              ///< of construction
  std::optional<std::uint64_t> peakBytes;     ///< peak memory during construction
  double hypervolume = 0;                     ///< enclosed by the mesh
  std::optional<double> hypervolumeExpected;  ///< of the true moving solid
  CellShapes shapes;

  /// The relative error of the hypervolume.
  std::optional<double> hypervolumeError() const;
};

/// Lengths and times are in the units of `a`.
struct Comparison {
  ComparedMesh a;
  ComparedMesh b;
  std::vector<measure::SliceComparison> slices;
  std::optional<double> volumeExpected;  ///< of the true solid, the same at any time

  /// The symmetric difference of all slices together, as a fraction of the volumes of a; empty if
  /// these are zero.
  std::optional<double> meanDifference() const;
  /// The largest Hausdorff distance over the times when both solids exist.
  double largestHausdorff() const;
};

/// The contents of the page.
struct CompareReport {
  std::string title;
  std::string lengthUnit;  ///< "" if unknown
  std::string timeUnit;
  /// One per voxel size, in descending order, all with the same a. The last is shown in detail.
  std::vector<Comparison> comparisons;
  std::vector<std::string> notes;
  std::vector<SolidPair> pairs;  ///< of the last comparison
  bool zUp = false;
};

/// One self-contained HTML page: tables, plots over time, the convergence for several voxel sizes,
/// and pictures of the solids, plain and coloured by the distance of one from the other.
std::string comparePage(const CompareReport& report);

/// The order of convergence of each error over the voxel sizes; empty if undefined.
struct ConvergenceOrders {
  std::optional<double> hypervolume;
  std::optional<double> difference;
  std::optional<double> hausdorff;
};
ConvergenceOrders ordersOf(std::span<const Comparison> comparisons);

/// Tables for page and terminal: the first row is the heading.
using Table = std::vector<std::vector<std::string>>;

/// Compares the two meshes: a label, a, b, and the ratio of b to a where it is meaningful.
Table meshTable(const CompareReport& report, const Comparison& comparison);

/// One row per time.
Table sliceTable(const CompareReport& report, const Comparison& comparison);

/// A row for the mesh method, one per voxel size, and one with the orders of convergence.
Table convergenceTable(const CompareReport& report);

}  // namespace t4d::tools
