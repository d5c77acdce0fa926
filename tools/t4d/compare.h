#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/check.h"
#include "t4d/surface.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/surface_agreement.h"

namespace t4d::tools {

class Members;

/// Values that 1, 50 and 99 per cent of the cells do not exceed.
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
  std::optional<std::uint64_t> frames;        ///< if the voxel method made it for this comparison
  std::optional<double> seconds;              ///< of construction
  std::optional<std::uint64_t> peakBytes;     ///< peak memory during construction
  double hypervolume = 0;                     ///< enclosed by the mesh
  std::optional<double> hypervolumeExpected;  ///< of the true moving solid
  CellShapes shapes;

  /// The relative error of the hypervolume.
  std::optional<double> hypervolumeError() const;
};

/// Two solids at one time. What both have in common is computed from the symmetric difference.
struct ComparedSlice : measure::SliceComparison {
  SurfaceAgreement surfaces;

  double volumeDifference() const { return volumeB - volumeA; }
  /// Twice the volume of both as a part of the sum of their volumes; nothing if both are empty.
  std::optional<double> dice() const;
  /// The volume of both as a part of that of either.
  std::optional<double> jaccard() const;
};

/// A body of both meshes, or of one.
struct ComparedBody {
  std::string name;
  std::vector<ComparedSlice> slices;  ///< at the times of Comparison::slices
};

/// Lengths and times are in the units of `a`.
struct Comparison {
  ComparedMesh a;
  ComparedMesh b;
  std::vector<ComparedSlice> slices;
  std::optional<double> volumeExpected;   ///< of the true solid, the same at any time
  std::vector<ComparedBody> bodies = {};  ///< if they are asked for

  /// The symmetric difference of all slices together, as a fraction of the volumes of a; empty if
  /// these are zero.
  std::optional<double> meanDifference() const;
  /// The largest Hausdorff distance over the times when both solids exist.
  double largestHausdorff() const;
};

/// Two solids at one time.
struct SolidPair {
  double time = 0;
  model::TriangleMesh a;
  model::TriangleMesh b;
};

struct CompareReport {
  std::string lengthUnit;  ///< "" if unknown
  std::string timeUnit;
  /// One for each of the others, in their order, all with the same a.
  std::vector<Comparison> comparisons;
  std::vector<std::string> notes;
  std::vector<SolidPair> pairs;  ///< of the last comparison
  bool zUp = false;              ///< of a
};

/// A .t4d file (path or URL), and what is known of how it was made: the rest of `mesh` is measured.
struct ComparedFile {
  std::string path;
  ComparedMesh mesh = {};
};

struct CompareOptions {
  std::vector<double> times = {};              ///< to compare at; none for `slices`
  std::optional<std::uint64_t> slices = {};    ///< evenly spaced times; nothing for up to 9
  std::optional<std::uint64_t> maxCells = {};  ///< as T4dReader::open takes it
  std::optional<double> volumeExpected = {};   ///< of the true solid, at any time
  std::size_t pairs = 0;                       ///< solids to keep in the report
  bool eachBody = false;                       ///< compare bodies of the same name, too
};

/// Compares each of `others`, at least one, with `a`, in the units of `a` (measure::compareSolids).
/// An invalid mesh is compared, too, with a notice. Fails for units that cannot be converted, and
/// for times at which nothing exists.
Result<CompareReport> compare(const ComparedFile& a, std::span<const ComparedFile> others,
                              const CompareOptions& options, Observer& observer = nobody());

/// The order of convergence of each error over the voxel sizes: the slope of the least-squares line
/// through the logarithms. Empty if undefined.
struct ConvergenceOrders {
  std::optional<double> hypervolume;
  std::optional<double> difference;
  std::optional<double> hausdorff;
};
ConvergenceOrders ordersOf(std::span<const Comparison> comparisons);

void describe(Members& members, const CompareReport& report);

/// A heading and a row for each time of each comparison and, if there are bodies, instead for each
/// body at each time, in a column `body`; what is undefined is left empty. Numbers are in the
/// shortest form that reads back as the same double.
std::string csvOf(const CompareReport& report);

}  // namespace t4d::tools
