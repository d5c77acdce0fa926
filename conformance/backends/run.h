#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "conformance/backends/backend.h"
#include "conformance/backends/case.h"
#include "conformance/oracle.h"

namespace t4d::conformance {

/// The result of a case at one resolution.
struct Level {
  Resolution resolution;
  MeshResult mesh;
  std::optional<double> hypervolumeError;  ///< |found - true| / true, if the true one is known
  std::optional<double> sliceError;        ///< the root mean square of this over slices
};

/// How fast errors fall with the voxel size.
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
  std::optional<double> hypervolumeExpected;  ///< at the finest level
  std::optional<double> worstError;           ///< relative, of any volume at the finest level
  Orders orders;
  double seconds = 0;

  bool passed() const;
  std::size_t passedChecks() const;
};

/// Builds the case at each resolution and verifies the meshes. `quick` skips the finest resolution
/// if there are more than two. A backend that returns an error fails the check "made".
///
/// Errors should fall with the square of the voxel size h (expectations.h), so order 2 is expected
/// between the coarsest and the finest, or VoxelPlan::order. For masks, only the order of slices is
/// checked. The constant before h^2 depends on the position of the surface on the lattice; the
/// tolerance allows it to change by a factor of two.
CaseResult runCase(const Case& given, const Backend& backend, bool quick,
                   const model::Progress& progress = {});

struct Job {
  const Case* given = nullptr;
  const Backend* backend = nullptr;
};

/// Runs several cases in parallel. The results are in the order of the jobs and, except for the
/// seconds, the same for any number of threads. `finished` is called after each case, never
/// concurrently.
std::vector<CaseResult> runCases(std::span<const Job> jobs, bool quick,
                                 const std::function<void(const CaseResult&)>& finished = {});

}  // namespace t4d::conformance
