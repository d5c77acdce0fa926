#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "edit/cell_shape.h"
#include "edit/collapse_patch.h"
#include "edit/common_attributes.h"
#include "edit/patch.h"
#include "edit/proved_collapse.h"
#include "edit/slab_windows.h"
#include "measure/space_time_tetrahedron.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "model/source_part.h"
#include "t4d/check.h"
#include "t4d/edit.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Slab;

using Slabs = std::vector<std::shared_ptr<const Slab>>;

/// How far samples may be at the first try, as a part of the largest error: between them slices are
/// farther.
constexpr double kFirstReach = 0.8;

/// A window after the first step, or several joined, with what is left to do.
struct Simplified {
  Patch patch;
  Original original = {};  // with a largest error
  double goal = 0;         // cells that are to be left
  double goalNow = 0;      // and before the seam with the next is simplified
};

class Simplifier {
 public:
  /// Works in coordinates from `origin`.
  Simplifier(const model::Source& source, const SimplifyOptions& options, double timeScale,
             const model::Point3& origin, model::Sink& sink)
      : source_(source), options_(options), timeScale_(timeScale), origin_(origin), sink_(sink) {
    const model::TimeSpan span = model::timeSpanOf(source);
    collapse_.firstTime = span.begin * timeScale;
    collapse_.lastTime = span.end * timeScale;
    collapse_.preserve = options.preserve;
  }

  Result<Slabs> read(const Window& window, const std::vector<Attribute>& attributes) const {
    Slabs slabs;
    for (std::size_t i = window.begin; i < window.end; ++i) {
      auto slab = source_.slab(i);
      if (!slab) return slab.error();
      slabs.push_back(withOnly(attributes, *slab));
    }
    return slabs;
  }

  /// Simplifies what has no vertex in the first and the last layer of a window.
  Result<Simplified> inside(const Slabs& slabs) const {
    auto patch = patchOf(slabs, timeScale_);
    if (!patch) return patch.error();
    for (model::Point4& vertex : patch->vertices) vertex.head<3>() -= origin_;
    if (options_.maxError) {
      std::ranges::fill(patch->reaches, kFirstReach * *options_.maxError);
      addSamples(*patch);
    }
    // Cells at a layer are for the steps that simplify it. Without a ratio, errors alone decide.
    const double ratio = options_.ratio.value_or(1);
    const auto cells = static_cast<double>(patch->cells.size());
    const double atLower = cellsAt(*patch, 0, patch->lowerCount);
    const double atUpper = cellsAt(*patch, patch->firstUpper(), patch->vertexCount());
    Simplified made;
    made.goal = ratio * cells;
    made.goalNow = made.goal + (1 - ratio) * atUpper;
    CollapseOptions options = collapse_;
    options.cells = cellsFor(made.goalNow + (1 - ratio) * atLower);
    if (options_.maxError) {
      made.original = originalOf(*patch);
      made.patch = provedCollapse(*patch, made.original, *options_.maxError, options);
    } else {
      made.patch = collapsed(std::move(*patch), options).patch;
    }
    return made;
  }

  /// Simplifies the layer between the last window and this one. If they are small together, they
  /// become one; otherwise the layer stays, and the last is put.
  Result<void> add(Simplified next) {
    if (!last_) {
      last_ = std::move(next);
      return {};
    }
    if (last_->patch.upperCount == 0 || last_->patch.upperCount != next.patch.lowerCount) {
      return putLastBefore(std::move(next));
    }
    const bool joins = isJoinedWith(next);
    CollapseOptions options = collapse_;
    options.cells = cellsFor(lastGoal() + next.goalNow);
    Patch whole = joined(std::move(last_->patch), next.patch);
    if (joins) whole.forgetSeam();
    Original original = joined(std::move(last_->original), next.original);
    if (options_.maxError) {
      whole = provedCollapse(whole, original, *options_.maxError, options);
    } else {
      whole = collapsed(std::move(whole), options).patch;
    }
    if (joins) {
      last_ = Simplified{std::move(whole), std::move(original), last_->goal + next.goal};
      return {};
    }
    PatchPair parts = parted(whole);
    last_->patch = std::move(parts.lower);
    next.patch = std::move(parts.upper);
    return putLastBefore(std::move(next));
  }

  Result<void> putLast() {
    excess_ += static_cast<double>(last_->patch.cells.size()) - last_->goal;
    for (model::Point4& vertex : last_->patch.vertices) vertex.head<3>() += origin_;
    return sink_.put(slabOf(std::move(last_->patch), timeScale_));
  }

 private:
  Result<void> putLastBefore(Simplified next) {
    auto put = putLast();
    last_ = std::move(next);
    return put;
  }

  /// The goal of the last window, less what those before it have too many, within reason: one
  /// window would pay for all.
  double lastGoal() const {
    constexpr double kLeastOfGoal = 0.9;
    return std::max(kLeastOfGoal * last_->goal, last_->goal - excess_);
  }

  /// Whether the last window and this one, which share a layer, become one slab. Slabs without
  /// thickness stay, and windows of a given length.
  bool isJoinedWith(const Simplified& next) const {
    const auto isFlat = [](const Patch& patch) { return patch.timeBegin == patch.timeEnd; };
    return !options_.windowSlabs && !isFlat(last_->patch) && !isFlat(next.patch) &&
           last_->patch.cells.size() <= options_.windowCells &&
           2 * (last_->goal + next.goal) <= static_cast<double>(options_.windowCells);
  }

  /// Each vertex that is in a slice, and the middle of each edge that is long against the largest
  /// error.
  void addSamples(Patch& patch) const {
    constexpr double kLong = 16;
    const double longest = kLong * *options_.maxError;
    std::vector<bool> isSample(patch.vertices.size());
    std::vector<std::array<std::uint32_t, 3>> edges;  // two ends and a cell
    for (std::uint32_t i = 0; i < patch.cells.size(); ++i) {
      const auto& at = patch.vertices;
      const model::Cell& cell = patch.cells[i];
      if (measure::isAtOneTime(cornersOf(at, cell))) continue;
      for (int k = 0; k < 4; ++k) {
        if (!isSample[cell[k]]) patch.samples.push_back({at[cell[k]], i});
        isSample[cell[k]] = true;
        for (int j = 0; j < k; ++j) {
          if ((at[cell[k]] - at[cell[j]]).norm() <= longest) continue;
          const auto [from, to] = std::minmax(cell[k], cell[j]);
          edges.push_back({from, to, i});
        }
      }
    }
    std::ranges::sort(edges);
    const auto isSame = [](const auto& a, const auto& b) { return a[0] == b[0] && a[1] == b[1]; };
    edges.erase(std::unique(edges.begin(), edges.end(), isSame), edges.end());
    for (const auto& [from, to, cell] : edges) {
      patch.samples.push_back({(patch.vertices[from] + patch.vertices[to]) / 2, cell});
    }
  }

  std::uint64_t cellsFor(double goal) const {
    return options_.ratio ? static_cast<std::uint64_t>(std::max(goal, 0.0)) : 0;
  }

  /// The number of cells with one of these vertices.
  static double cellsAt(const Patch& patch, std::uint32_t begin, std::uint32_t end) {
    const auto isAt = [&](const model::Cell& cell) {
      return std::ranges::any_of(cell, [&](std::uint32_t v) { return v >= begin && v < end; });
    };
    return static_cast<double>(std::ranges::count_if(patch.cells, isAt));
  }

  const model::Source& source_;
  const SimplifyOptions& options_;
  double timeScale_;
  model::Point3 origin_;
  model::Sink& sink_;
  CollapseOptions collapse_;
  std::optional<Simplified> last_;
  double excess_ = 0;  // how many cells more than their goals the windows put have
};

Result<void> checkOptions(const SimplifyOptions& options) {
  const auto wrong = [](std::string message) {
    return fail(ErrorCode::Options, std::move(message));
  };
  if (!options.ratio && !options.maxError) {
    return wrong("a part of the cells to keep or a largest error is needed");
  }
  if (options.ratio && !(*options.ratio > 0 && *options.ratio <= 1)) {
    return wrong(fmt::format("the part of the cells to keep is {}, not above 0 and at most 1",
                             *options.ratio));
  }
  if (options.maxError && !(*options.maxError > 0)) {
    return wrong(fmt::format("the largest error is {}, not above 0", *options.maxError));
  }
  if (!(options.timeScale > 0) || !std::isfinite(options.timeScale)) {
    return wrong(fmt::format("the time scale is {}, not a number above 0", options.timeScale));
  }
  return {};
}

Result<void> checkPreserved(const std::string& name, const std::vector<Attribute>& common) {
  if (name.empty()) return {};
  std::vector<std::string> names;
  for (const Attribute& attribute : common) {
    if (attribute.domain == model::Domain::Cell) names.push_back(attribute.name);
  }
  if (std::ranges::find(names, name) != names.end()) return {};
  return fail(
      ErrorCode::Options,
      fmt::format(
          "no attribute '{}' of cells in all slabs has borders to preserve; {}", name,
          names.empty() ? "there is none" : fmt::format("there is {}", fmt::join(names, ", "))));
}

/// The findings of a first reading of the mesh.
struct Survey {
  measure::MeshReport mesh;
  CommonAttributes attributes;
};

Result<Survey> surveyOf(const model::Source& source, const measure::CheckOptions& options) {
  measure::MeshChecker checker(options);
  Survey survey;
  model::Tee both({&checker, &survey.attributes});
  if (auto read = model::pump(source, both); !read) return read.error();
  survey.mesh = checker.finish();
  if (survey.mesh.valid()) return survey;
  const auto& issues = survey.mesh.issues.issues;
  const auto error = std::ranges::find(issues, measure::Severity::Error, &measure::Issue::severity);
  return invalid(fmt::format("only a closed, oriented and manifold mesh can be simplified: {}",
                             error->message),
                 {}, Remedy::Recover);
}

double powerOfTwoNear(double scale) { return std::exp2(std::round(std::log2(scale))); }

/// A point near the middle, in steps as large as the mesh: coordinates less it are exact, and those
/// of a mesh that is far away have more digits.
model::Point3 originNear(const model::Bounds4& bounds) {
  const model::Point3 middle = ((bounds.min + bounds.max) / 2).head<3>();
  const double size = (bounds.max - bounds.min).head<3>().maxCoeff();
  if (!(size > 0)) return model::Point3::Zero();
  const double step = std::exp2(std::ceil(std::log2(size)));
  return step * (middle / step).array().round().matrix();
}

}  // namespace

Result<SimplifyReport> simplify(const model::Source& source, const SimplifyOptions& options,
                                model::Sink& sink, const model::Progress& progress) {
  if (auto sound = checkOptions(options); !sound) return sound.error();
  if (source.slabCount() == 0) return invalid("the mesh has no cells");
  const auto all = windowsOf(source, options.windowSlabs, options.windowCells);
  if (!all) return all.error();
  const auto windows = windowsOfPart(*all, options.part);
  if (!windows) return windows.error();
  const measure::CheckOptions asPart = {.vertexLinks = true,
                                        .goesOnBefore = !options.part.isFirst(),
                                        .goesOnAfter = !options.part.isLast()};
  const auto sound =
      surveyOf(model::SourcePart(source, windows->front().begin, windows->back().end), asPart);
  if (!sound) return sound.error();
  const auto& [before, common] = *sound;
  if (auto known = checkPreserved(options.preserve, common.attributes()); !known) {
    return known.error();
  }
  measure::MeshChecker after(asPart);
  model::Tee both({&after, &sink});
  Simplifier simplifier(source, options, powerOfTwoNear(options.timeScale),
                        originNear(before.bounds), both);
  Result<void> done;
  using Read = std::shared_ptr<const Result<Slabs>>;
  using Made = std::shared_ptr<Result<Simplified>>;
  model::inOrder<Read, Made>(
      windows->size(), model::threadCount(),
      [&](std::size_t i) {
        return std::make_shared<const Result<Slabs>>(
            simplifier.read((*windows)[i], common.attributes()));
      },
      [&](const Read& slabs) {
        return std::make_shared<Result<Simplified>>(*slabs ? simplifier.inside(**slabs)
                                                           : Result<Simplified>(slabs->error()));
      },
      [&, count = std::size_t{0}](const Made& made) mutable {
        done = *made ? simplifier.add(std::move(**made)) : Result<void>(made->error());
        if (done) done = model::report(progress, ++count, windows->size());
        return done.has_value();
      });
  if (done) done = simplifier.putLast();
  if (!done) return done.error();
  const measure::MeshReport result = after.finish();
  SimplifyReport report;
  report.cellsBefore = before.tetrahedra;
  report.verticesBefore = before.vertices;
  report.hypervolumeBefore = before.hypervolume;
  report.cells = result.tetrahedra;
  report.vertices = result.vertices;
  report.hypervolume = result.hypervolume;
  report.maxError = options.maxError;
  report.slabs = {windows->front().begin, windows->back().end};
  report.droppedAttributes = common.others();
  return report;
}

}  // namespace t4d::edit
