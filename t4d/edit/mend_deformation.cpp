#include "t4d/edit/mend_deformation.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "t4d/edit/mend_steps.h"
#include "t4d/edit/surface_crossings.h"
#include "t4d/measure/surface_distance.h"
#include "t4d/model/surface_check.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

/// Two vertices that became one, and how far apart they may be.
struct MergedPair {
  std::uint32_t kept;
  std::uint32_t gone;
  double apart;  ///< along any axis
};

/// The keys of some of the vertices.
class KeysOfSome : public model::VertexKeys {
 public:
  KeysOfSome(std::unique_ptr<model::VertexKeys> all, std::size_t vertices,
             std::vector<std::uint32_t> kept, std::vector<MergedPair> merged)
      : all_(std::move(all)),
        places_(vertices),
        kept_(std::move(kept)),
        merged_(std::move(merged)) {}

  std::uint64_t count() const override { return all_->count(); }
  double time(std::uint64_t key) const override { return all_->time(key); }
  std::optional<model::Affine3x4> pose(std::uint64_t key) const override { return all_->pose(key); }
  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    if (auto read = all_->positions(key, places_); !read) return read;
    for (const MergedPair& pair : merged_) {
      const double apart = (places_[pair.gone] - places_[pair.kept]).cwiseAbs().maxCoeff();
      if (apart <= pair.apart) continue;
      return invalid(fmt::format("vertices {} and {} were merged, but are {:.6g} apart at time {}",
                                 pair.kept, pair.gone, apart, time(key)),
                     {}, Remedy::Motion);
    }
    for (std::size_t i = 0; i < kept_.size(); ++i) into[i] = places_[kept_[i]];
    return {};
  }

 private:
  std::unique_ptr<model::VertexKeys> all_;
  mutable std::vector<Point3> places_;
  std::vector<std::uint32_t> kept_;
  std::vector<MergedPair> merged_;
};

/// For each vertex of a triangle that is another one after merging, both.
std::vector<MergedPair> mergedPairs(const TriangleMesh& before, const TriangleMesh& after,
                                    double weld) {
  std::vector<MergedPair> pairs;
  for (std::size_t i = 0; i < before.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t gone = before.triangles[i][k];
      const std::uint32_t kept = after.triangles[i][k];
      if (gone == kept) continue;
      const Point3 apart = (before.vertices[gone] - before.vertices[kept]).cwiseAbs();
      pairs.push_back({kept, gone, std::max(weld, apart.maxCoeff())});
    }
  }
  const auto byGone = [](const MergedPair& pair) { return pair.gone; };
  std::ranges::sort(pairs, {}, byGone);
  const auto again = std::ranges::unique(pairs, {}, byGone);
  pairs.erase(again.begin(), again.end());
  return pairs;
}

/// Fails unless the surface bounds a solid as it is.
Result<void> checkNothingToMove(const TriangleMesh& mesh, bool nested) {
  constexpr const char* kWhy = "mending that would move vertices, which it cannot at every key";
  if (auto closed = model::checkClosedSurface(mesh); !closed) {
    return invalid(fmt::format("{}; {}", closed.error().message, kWhy));
  }
  if (nested) {
    return invalid(fmt::format("components lie inside others at the first key; {}", kWhy));
  }
  if (!findsCrossings()) return {};
  constexpr std::size_t kCounted = 1000;
  const auto crossings = findCrossings(mesh, kCounted);
  if (!crossings) return crossings.error();
  if (crossings->none()) return {};
  return invalid(fmt::format("{}{} pairs of triangles meet and {} are flat at the first key; {}",
                             crossings->complete ? "" : "more than ", crossings->pairs.size(),
                             crossings->flat.size(), kWhy));
}

}  // namespace

Result<MendSurfaceReport> mendDeformation(TriangleMesh& mesh,
                                          std::unique_ptr<model::VertexKeys>& keys,
                                          const MendSurfaceOptions& options) {
  TriangleMesh before{std::vector<Point3>(mesh.vertices.size()), mesh.triangles, {}};
  if (auto read = keys->positions(0, before.vertices); !read) return read.error();
  if (auto checked = checkElements(before); !checked) return checked.error();
  MendSurfaceReport report;
  TriangleMesh work = before;
  weld(work, options.weld, report.changes);
  auto merged = mergedPairs(before, work, options.weld);
  const TriangleMesh welded = work;
  measureBefore(welded, report);
  if (auto dropped = dropDuplicates(work, report.changes); !dropped) return dropped.error();
  const model::UnitScale scale = model::UnitScale::of({&work});
  if (scale.changes()) work = scale.toUnit(work);
  dropStray(work, report.changes);
  auto kept = dropUnusedVertices(work);
  auto done = orient(work, report.changes);
  if (done) done = fillHoles(work, options, scale, report.changes);
  if (!done) {
    Error error = done.error();
    if (error.remedy == Remedy::Remesh) error.remedy = Remedy::None;
    return error;
  }
  const bool nested = faceOutward(work, report.changes);
  if (auto good = checkNothingToMove(work, nested); !good) return good.error();
  report.components = componentsOf(work).size();
  for (std::size_t i = 0; i < kept.size(); ++i) work.vertices[i] = before.vertices[kept[i]];
  if (!report.changes.empty()) {
    constexpr double kTolerance = 1e-4;
    report.hausdorff = measure::surfaceDistance(before, work, kTolerance).hausdorff();
  }
  measureAfter(welded, work, options, report);
  report.closed = report.manifold = true;
  if (findsCrossings()) report.selfIntersections = 0;
  keys = std::make_unique<KeysOfSome>(std::move(keys), mesh.vertices.size(), std::move(kept),
                                      std::move(merged));
  mesh = std::move(work);
  return report;
}

}  // namespace t4d::edit
