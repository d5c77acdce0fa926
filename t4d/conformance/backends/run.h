#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/conformance/backends/backend.h"
#include "t4d/conformance/backends/case.h"
#include "t4d/conformance/oracle.h"

namespace t4d::conformance {

/// What one resolution of a case led to.
struct Level {
  Resolution resolution;
  MeshResult mesh;
  std::optional<double> hypervolumeError;  ///< |found - true| / true, if the true one is known
  std::optional<double> sliceError;        ///< root of the mean square over slices, likewise
};

/// How fast errors fall with the size of voxels.
struct Orders {
  std::optional<double> hypervolume;
  std::optional<double> slices;
};

struct CaseResult {
  std::string id;
  std::string description;
  std::string backend;
  std::vector<Check> checks;  ///< of all levels, and of the orders
  std::vector<Level> levels;
  std::optional<double> hypervolumeExpected;  ///< of the finest level
  std::optional<double> worstError;           ///< relative, of any volume of the finest level
  Orders orders;
  double seconds = 0;

  bool passed() const;
  std::size_t passedChecks() const;
};

/// Builds the case at each resolution and verifies the meshes. `quick` leaves out the finest
/// resolution if there are more than two. A backend that returns an error fails the check "made".
///
/// Errors should fall with the square of the voxel size h (expectations.h): expected is order 2
/// between the coarsest and the finest. How the surface lies on the lattice changes the factor
/// before h^2; the tolerance is what a change of that by two makes.
CaseResult runCase(const Case& given, const Backend& backend, bool quick,
                   const model::Progress& progress = {});

struct Job {
  const Case* given = nullptr;
  const Backend* backend = nullptr;
};

/// Runs several cases at a time; the results are in the order of the jobs and, but for the seconds,
/// the same for any number of threads. `finished` is called as each is done, one at a time.
std::vector<CaseResult> runCases(std::span<const Job> jobs, bool quick,
                                 const std::function<void(const CaseResult&)>& finished = {});

}  // namespace t4d::conformance
