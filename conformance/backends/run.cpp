#include <algorithm>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

#include "model/parallel.h"
#include "model/progress.h"
#include "platform/stopwatch.h"
#include "t4d/conformance.h"

namespace t4d::conformance {
namespace {

std::optional<double> relativeError(const Measure& expected, double actual) {
  if (!(expected.value > 0)) return std::nullopt;
  return std::abs(actual - expected.value) / expected.value;
}

double refinementOf(const std::vector<Level>& levels) {
  return std::log(levels.front().resolution.voxelSize / levels.back().resolution.voxelSize);
}

/// The order of convergence of an error.
std::optional<double> orderOf(std::optional<double> Level::*error,
                              const std::vector<Level>& levels) {
  const auto& coarse = levels.front().*error;
  const auto& fine = levels.back().*error;
  if (!coarse || !fine) return std::nullopt;
  return std::log(*coarse / *fine) / refinementOf(levels);
}

void checkOrder(const std::string& of, double expected, std::optional<double> order,
                CaseResult& result) {
  if (!order) return;
  result.checks.push_back(measureIs(
      fmt::format("order of convergence of the {}", of),
      {expected, std::log(2) / refinementOf(result.levels),
       fmt::format("the error is of order h^{:g}; its constant may vary by a factor of two with "
                   "the lattice",
                   expected)},
      *order));
}

}  // namespace

bool CaseResult::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.passed; });
}

std::size_t CaseResult::passedChecks() const {
  return static_cast<std::size_t>(
      std::count_if(checks.begin(), checks.end(), [](const Check& check) { return check.passed; }));
}

CaseResult runCase(const Case& given, const Backend& backend, bool quick,
                   const model::Progress& progress) {
  const platform::Stopwatch stopwatch;
  CaseResult result{given.id, given.description, backend.name(), {}, {}, {}, {}, {}, 0};
  std::vector<Resolution> resolutions = backend.resolutions(given);
  if (quick && resolutions.size() > 2) resolutions.pop_back();
  for (std::size_t i = 0; i < resolutions.size(); ++i) {
    const Resolution& resolution = resolutions[i];
    const std::string prefix =
        resolutions.size() > 1 ? fmt::format("h = {:g}: ", resolution.voxelSize) : std::string();
    model::Mesh mesh;
    const auto expectation = backend.expectation(given, resolution);
    const auto built =
        expectation ? backend.build(given, resolution, mesh) : Result<void>(expectation.error());
    result.checks.push_back(holds(prefix + "made", true, built.has_value(),
                                  "the backend makes a mesh of the case",
                                  built ? std::string() : built.error().text()));
    if (!built) break;

    Level level{resolution, verify(mesh, *expectation), {}, {}};
    for (const Check& check : level.mesh.checks) {
      result.checks.push_back(check);
      result.checks.back().name = prefix + check.name;
    }
    if (expectation->hypervolume) {
      level.hypervolumeError = relativeError(*expectation->hypervolume, level.mesh.hypervolume);
      result.hypervolumeExpected = expectation->hypervolume->value;
    }
    result.worstError = level.hypervolumeError;
    double squares = 0;
    int count = 0;
    for (std::size_t k = 0; k < level.mesh.sliceVolumes.size(); ++k) {
      const auto& expected = expectation->slices[k].volume;
      const auto& actual = level.mesh.sliceVolumes[k];
      if (!expected || !actual) continue;
      const auto error = relativeError(*expected, *actual);
      if (!error) continue;
      squares += *error * *error;
      ++count;
      result.worstError = std::max(result.worstError.value_or(0), *error);
    }
    if (count > 0) level.sliceError = std::sqrt(squares / count);
    result.levels.push_back(std::move(level));
    if (!model::report(progress, i + 1, resolutions.size())) break;
  }
  if (result.levels.size() == resolutions.size() && resolutions.size() > 1) {
    result.orders = {orderOf(&Level::hypervolumeError, result.levels),
                     orderOf(&Level::sliceError, result.levels)};
    const VoxelPlan& plan = given.voxels;
    // Errors of masks have either sign; how far they cancel over time is chance.
    if (plan.maskMotion == 0) {
      checkOrder("hypervolume", plan.order, result.orders.hypervolume, result);
    }
    checkOrder("slices' volumes", plan.order, result.orders.slices, result);
  }
  result.seconds = stopwatch.seconds();
  return result;
}

std::vector<CaseResult> runCases(std::span<const Job> jobs, bool quick,
                                 const std::function<void(const CaseResult&)>& finished) {
  std::vector<CaseResult> results(jobs.size());
  std::mutex oneAtATime;
  model::forEachTask(jobs.size(), [&](std::size_t i) {
    model::isolate([&] { results[i] = runCase(*jobs[i].given, *jobs[i].backend, quick); });
    const std::scoped_lock lock(oneAtATime);
    if (finished) finished(results[i]);
  });
  return results;
}

}  // namespace t4d::conformance
