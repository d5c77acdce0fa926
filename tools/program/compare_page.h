#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/measure/compare.h"

namespace t4d::tools {

/// One of the two 4D meshes: what is known of it.
struct ComparedMesh {
  std::string name;     ///< of the file; "" where it is not the user's
  std::string backend;  ///< "" where the file does not say
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t bytes = 0;                    ///< of the file
  std::optional<double> seconds;              ///< of construction
  std::optional<std::uint64_t> peakBytes;     ///< largest memory in construction
  double hypervolume = 0;                     ///< as the mesh has it
  std::optional<double> hypervolumeExpected;  ///< of the true moving solid

  /// How far the mesh is off, as a fraction of the true hypervolume.
  std::optional<double> hypervolumeError() const;
};

struct Comparison {
  std::string title;
  ComparedMesh a;
  ComparedMesh b;
  std::vector<measure::SliceComparison> slices;
  std::optional<double> volumeExpected;  ///< of the true solid, at any time
  std::string lengthUnit;                ///< "" where not known
  std::string timeUnit;
};

/// A pair of solids to show in pictures.
struct SolidPair {
  double time = 0;
  model::TriangleMesh a;
  model::TriangleMesh b;
};

/// The table, plots over time, and pictures of the solids, as one HTML page that loads nothing.
/// Pictures show both solids, plain and coloured by the distance of one from the other.
std::string comparePage(const Comparison& comparison, const std::vector<SolidPair>& pairs,
                        bool zUp);

/// The rows that say what the meshes are: a label, and the text for each. Shared by page and
/// terminal.
struct CompareRow {
  std::string label;
  std::string a;
  std::string b;
  std::string ratio;  ///< of b to a; "" where it says nothing
};
std::vector<CompareRow> compareRows(const Comparison& comparison);

/// The columns of the slices' table and its rows, likewise.
std::vector<std::string> sliceColumns();
std::vector<std::string> sliceRow(const measure::SliceComparison& slice);

}  // namespace t4d::tools
