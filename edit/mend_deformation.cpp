#include "edit/mend_deformation.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "edit/carried_attributes.h"
#include "edit/derived_keys.h"
#include "edit/mend_steps.h"
#include "edit/surface_crossings.h"
#include "edit/thicken_sheets.h"
#include "model/surface_check.h"
#include "t4d/check.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

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

/// Fails if triangles meet or components are nested, unless that is accepted.
Result<void> checkApart(const TriangleMesh& mesh, bool nested, Crossings crossings) {
  constexpr const char* kWhy = "mending that would move vertices, which it cannot at every key";
  if (crossings == Crossings::Accepted) return {};
  if (nested) {
    return invalid(
        fmt::format("components lie inside others or touch along edges at the first key; {}", kWhy),
        {}, Remedy::ConeCapsAlone);
  }
  if (!findsCrossings()) return {};
  constexpr std::size_t kCounted = 1000;
  const auto found = findCrossings(mesh, kCounted);
  if (!found) return found.error();
  if (found->none()) return {};
  return invalid(fmt::format("{}{} pairs of triangles meet and {} are flat at the first key; {}",
                             found->complete ? "" : "more than ", found->pairs.size(),
                             found->flat.size(), kWhy),
                 {}, Remedy::ConeCapsAlone);
}

/// Voxels cannot help at every key.
Error withoutRemeshing(Error error) {
  if (error.remedy == Remedy::Remesh) error.remedy = Remedy::None;
  return error;
}

/// The origins of vertices that follow others, by what these follow themselves.
std::vector<VertexOrigin> through(std::vector<VertexOrigin> origins,
                                  const std::vector<std::uint32_t>& kept) {
  for (VertexOrigin& origin : origins) {
    for (std::uint32_t& vertex : origin) vertex = kept[vertex];
  }
  return origins;
}

/// The runs of a surface in the making, each of which follows the run before.
class Followers {
 public:
  /// `local` are the vertices that poses move; none if there are no poses.
  Followers(std::size_t vertices, std::vector<Point3> local)
      : lineage_(vertices), local_(std::move(local)) {}

  void follow(std::vector<VertexOrigin> origins, std::vector<MergedPair> merged) {
    const std::size_t vertices = lineage_.origins().size();
    lineage_.follow(origins);
    if (!local_.empty()) {
      std::vector<Point3> moved;
      for (const VertexOrigin& origin : origins) moved.push_back(middleOf(local_, origin));
      local_ = std::move(moved);
    }
    makers_.emplace_back([=, mesh = std::make_shared<const std::vector<Point3>>(local_)](
                             std::unique_ptr<model::VertexKeys> run) {
      return std::make_unique<KeysOfOrigins>(std::move(run), vertices, origins, merged, mesh);
    });
  }

  void thicken(const ThickSheets& thick, double thickness) {
    lineage_.append(thick.sheet);
    local_.clear();  // the sides of a pose that scales are not apart by the thickness
    makers_.emplace_back([=](std::unique_ptr<model::VertexKeys> run) {
      return std::make_unique<KeysOfThickSheets>(std::move(run), thick.triangles, thick.sheet,
                                                 thickness);
    });
  }

  std::unique_ptr<model::VertexKeys> madeOf(std::unique_ptr<model::VertexKeys> run) const {
    for (const auto& maker : makers_) run = maker(std::move(run));
    return run;
  }

  bool empty() const { return makers_.empty(); }
  const std::vector<Point3>& local() const { return local_; }
  const VertexLineage& lineage() const { return lineage_; }

 private:
  VertexLineage lineage_;
  std::vector<Point3> local_;
  std::vector<std::function<std::unique_ptr<model::VertexKeys>(std::unique_ptr<model::VertexKeys>)>>
      makers_;
};

}  // namespace

Result<MendSurfaceReport> mendDeformation(TriangleMesh& mesh, Runs& runs,
                                          const MendSurfaceOptions& options, Crossings crossings) {
  TriangleMesh before{std::vector<Point3>(mesh.vertices.size()), mesh.triangles, {}};
  if (auto read = runs.front()->positions(0, before.vertices); !read) return read.error();
  if (auto checked = checkElements(before); !checked) return checked.error();
  Followers followers(mesh.vertices.size(),
                      runs.front()->pose(0) ? mesh.vertices : std::vector<Point3>());
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
  const auto kept = dropUnusedVertices(work);
  if (auto done = orient(work, report.changes); !done) return withoutRemeshing(done.error());

  if (options.thicken) {
    auto thick = thickSheetsOf(work, *options.thicken, scale, report.changes);
    if (!thick) return thick.error();
    if (*thick) {
      followers.follow(through((*thick)->origins, kept), merged);
      followers.thicken(**thick, *options.thicken);
      work = std::move((*thick)->mesh);
    }
  } else if (const auto sheets = countSheets(work); !sheets || *sheets > 0) {
    if (!sheets) return sheets.error();
    return invalid(fmt::format("{} nothing: open, and crossing what would close it",
                               numberOf(*sheets, "sheet encloses", "sheets enclose")),
                   {}, Remedy::Thicken);
  }
  if (auto done = fillHoles(work, options, scale, report.changes); !done) {
    return withoutRemeshing(done.error());
  }
  const bool nested = faceOutward(work, report.changes);
  if (auto good = checkApart(work, nested, crossings); !good) return good.error();
  report.components = componentsOf(work).size();

  const SplitSurface split = splitWhereTouching(work);
  noteSplit(split, report.changes);
  if (auto closed = model::checkClosedSurface(split.mesh); !closed) {
    return invalid(closed.error().message + ", also after mending");
  }
  if (followers.empty()) {
    followers.follow(through(split.origins, kept), merged);
  } else {
    followers.follow(split.origins, {});
  }
  Runs made;
  for (auto& run : runs) made.push_back(followers.madeOf(std::move(run)));
  runs = std::move(made);
  TriangleMesh after{std::vector<Point3>(split.mesh.vertices.size()), split.mesh.triangles, {}};
  if (auto read = runs.front()->positions(0, after.vertices); !read) return read.error();
  if (!report.changes.empty()) {
    constexpr double kTolerance = 1e-4;
    report.hausdorff = measure::surfaceDistance(before, after, kTolerance).hausdorff();
  }
  measureAfter(welded, after, options, report);
  report.closed = report.manifold = true;
  if (findsCrossings() && crossings == Crossings::Refused) report.selfIntersections = 0;
  before.attributes = std::move(mesh.attributes);
  mesh.attributes =
      carriedAttributes(before, welded.triangles, after, followers.lineage().origins());
  mesh.triangles = std::move(after.triangles);
  mesh.vertices = followers.local().empty() ? std::move(after.vertices) : followers.local();
  return report;
}

}  // namespace t4d::edit
