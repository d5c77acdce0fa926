#include "mill/mill.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "mill/motion_parts.h"
#include "mill/projected_volume.h"
#include "mill/solid_parts.h"
#include "mill/stock_field.h"
#include "model/surface_check.h"
#include "t4d/envelope.h"
#include "t4d/sweep.h"

namespace t4d::mill {
namespace {

using model::TimeSpan;
using model::TriangleMesh;

/// Takes the envelope of each step of a swept solid.
class Envelopes : public model::Sink {
 public:
  using Take = std::function<Result<void>(const TimeSpan&, TriangleMesh)>;
  explicit Envelopes(Take take) : take_(std::move(take)) {}

  Result<void> put(const model::Slab& slab) override {
    if (!(slab.timeEnd > slab.timeBegin)) return {};
    auto silhouette = silhouettes_.of(slab);
    if (!silhouette) return silhouette.error();
    return take_({slab.timeBegin, slab.timeEnd}, std::move(silhouette->surface));
  }

 private:
  Take take_;
  measure::SlabSilhouettes silhouettes_;
};

Result<void> sweepThrough(const TriangleMesh& solid, const model::Motion& motion, double tolerance,
                          const Envelopes::Take& take) {
  mesh4d::SweepOptions how;
  how.steps = mesh4d::MaxDeviation{tolerance};
  how.caps = mesh4d::CapMethod::Cone;
  // A straight move needs no vertices within prisms.
  const bool straight = std::ranges::all_of(motion.segments, [](const model::Segment& segment) {
    return segment.screw.angleDegrees == 0;
  });
  how.prism = straight ? mesh4d::PrismSplit::Three : mesh4d::PrismSplit::Fourteen;
  Envelopes sink(take);
  const auto swept = mesh4d::sweep(solid, motion, how, sink);
  if (swept) return {};
  Error error = swept.error();
  // The tolerance sets the steps.
  if (error.remedy == Remedy::StepRule) error.remedy = Remedy::Motion;
  return error;
}

double travelOf(const MillOptions& options) {
  return options.travel > 0 ? options.travel : 4 * options.voxelSize;
}

/// Calls `use` with each solid of a tool and its name.
Result<void> visitSolids(
    const Tool& tool,
    const std::function<Result<void>(const TriangleMesh&, const std::string&)>& use) {
  if (auto used = use(tool.mesh, partOfTool("tool", tool.number)); !used) return used;
  for (const Guard& guard : tool.guards) {
    if (auto used = use(guard.mesh, partOfTool(guard.name, tool.number)); !used) return used;
  }
  return {};
}

/// The largest distance from the tip of a point that moves with the tool.
double reachOf(const Tool& tool) {
  double reach = 0;
  const auto add = [&](const TriangleMesh& mesh, const std::string&) -> Result<void> {
    for (const model::Point3& vertex : mesh.vertices) reach = std::max(reach, vertex.norm());
    return {};
  };
  return visitSolids(tool, add) ? reach : 0;
}

/// Calls `use` with the parts of a span in which a tool is mounted, and the tool.
Result<void> visitMounted(const std::vector<Mounting>& mountings, const TimeSpan& span,
                          const std::function<Result<void>(const TimeSpan&, std::size_t)>& use) {
  if (mountings.empty()) return use(span, 0);
  for (std::size_t i = 0; i < mountings.size(); ++i) {
    const bool isLast = i + 1 == mountings.size();
    const TimeSpan part = {std::max(span.begin, mountings[i].time),
                           isLast ? span.end : std::min(span.end, mountings[i + 1].time)};
    if (!mountings[i].tool || !(part.begin < part.end)) continue;
    if (auto used = use(part, *mountings[i].tool); !used) return used;
  }
  return {};
}

/// Whether a ball can meet the stock.
Near nearTo(const StockField& field) {
  return [&field](const model::Point3& center, double radius) {
    const model::Point3 half = model::Point3::Constant(radius);
    return field.mayMeet({center - half, center + half});
  };
}

/// More steps, of a thousandth of a second and more each, would take hours: a wrong unit, or a
/// spindle that turns.
constexpr std::uint64_t kMostSteps = 10'000'000;

/// Fails if a motion goes so far that nothing is exact there, or asks for too many steps near the
/// stock.
Result<void> checkMotion(std::span<const Tool> tools, const model::Motion& motion,
                         const StockField& field, const MillOptions& options) {
  for (const Tool& tool : tools) {
    auto good = visitSolids(tool, [&](const TriangleMesh& mesh, const std::string& name) {
      auto reached = mesh4d::checkReach(mesh, motion);
      // What is wrong with the solid alone is wrong with this one, not with the stock.
      if (!reached && reached.error().remedy == Remedy::None) reached.error().where = name;
      return reached;
    });
    if (!good) return good;
  }
  double steps = 0;
  const auto count = [&](const model::Motion& part) -> Result<void> {
    for (const model::Segment& segment : part.segments) {
      steps += std::max(1.0, std::abs(segment.screw.angleDegrees));
    }
    if (steps <= static_cast<double>(kMostSteps)) return {};
    return fail(ErrorCode::Unsupported,
                fmt::format("the tool moves or turns near the stock for more than {} steps of "
                            "{:g} or a degree; is it in the length units of the stock?",
                            kMostSteps, travelOf(options)),
                {}, Remedy::Motion);
  };
  return visitMounted(options.mountings, {options.times.front(), options.times.back()},
                      [&](const TimeSpan& span, std::size_t tool) {
                        return visitParts(motion, span, travelOf(options), reachOf(tools[tool]),
                                          nearTo(field), count);
                      });
}

/// The workpiece at each time, made by going from frame to frame.
class Workpiece : public voxel4d::FrameSource {
 public:
  Workpiece(StockField field, std::span<const Tool> tools, const model::Motion& motion,
            const MillOptions& options, MillReport& report)
      : field_(std::move(field)),
        lattice_(field_.lattice()),
        tools_(tools),
        tool_(&tools.front()),
        motion_(motion),
        options_(options),
        travel_(travelOf(options)),
        report_(report) {}

  const voxel4d::Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return options_.times.size(); }

  Result<voxel4d::Frame> frame(std::size_t index) override {
    const double time = options_.times[index];
    if (index == 0) {
      components_ = countParts(field_);
    } else if (auto milled = millUntil({options_.times[index - 1], time}); !milled) {
      return milled.error();
    }
    report_.progress.push_back({time, 0, components_});
    return field_.frame(time);
  }

 private:
  /// An envelope that removed something.
  struct Cut {
    TimeSpan time;
    TriangleMesh envelope;
  };

  Result<void> millUntil(const TimeSpan& span) {
    const StockField before = field_;
    std::vector<Cut> cuts;
    auto cut =
        visitMounted(options_.mountings, span, [&](const TimeSpan& mounted, std::size_t tool) {
          tool_ = &tools_[tool];
          return visitParts(motion_, mounted, travel_, reachOf(*tool_), nearTo(field_),
                            [&](const model::Motion& part) { return cutAndGuard(part, cuts); });
        });
    if (!cut) return cut;
    if (cuts.empty()) return {};
    const std::uint64_t parts = countParts(field_);
    if (parts > components_) {
      if (auto found = findSeparations(before, cuts, parts); !found) return found;
    }
    components_ = parts;
    return {};
  }

  Result<void> cutAndGuard(const model::Motion& part, std::vector<Cut>& cuts) {
    if (tool_->guards.empty()) return cutAlong(part, cuts);
    // Guards follow the tool step by step.
    for (const model::Segment& segment : part.segments) {
      model::Motion step;
      step.segments = {segment};
      if (auto cut = cutAlong(step, cuts); !cut) return cut;
      if (auto guarded = guardAlong(step); !guarded) return guarded;
    }
    return {};
  }

  Result<void> cutAlong(const model::Motion& motion, std::vector<Cut>& cuts) {
    return sweepThrough(tool_->mesh, motion, options_.tolerance,
                        [&](const TimeSpan& time, TriangleMesh envelope) -> Result<void> {
                          ++report_.steps;
                          const auto removed = field_.remove(envelope);
                          if (!removed) return removed.error();
                          if (removed->changes && !report_.firstCut) {
                            report_.firstCut = time.begin;
                          }
                          if (removed->points == 0) return {};
                          if (isRapid(time)) collide("tool", time, removed->point);
                          cuts.push_back({time, std::move(envelope)});
                          return {};
                        });
  }

  Result<void> guardAlong(const model::Motion& motion) {
    for (const Guard& guard : tool_->guards) {
      auto guarded =
          sweepThrough(guard.mesh, motion, options_.tolerance,
                       [&](const TimeSpan& time, const TriangleMesh& envelope) -> Result<void> {
                         const auto met = field_.meet(envelope);
                         if (!met) return met.error();
                         if (met->points > 0) collide(guard.name, time, met->point);
                         return {};
                       });
      if (!guarded) return guarded;
    }
    return {};
  }

  bool isRapid(const TimeSpan& time) const {
    const double middle = 0.5 * (time.begin + time.end);
    const auto after = std::ranges::upper_bound(options_.rapids, middle, {}, &TimeSpan::begin);
    return after != options_.rapids.begin() && middle < std::prev(after)->end;
  }

  /// Steps that follow each other are one collision.
  void collide(const std::string& part, const TimeSpan& time, const model::Point3& point) {
    const auto same = std::find_if(
        report_.collisions.rbegin(), report_.collisions.rend(),
        [&](const Collision& one) { return one.part == part && one.tool == tool_->number; });
    if (same != report_.collisions.rend() && same->time.end >= time.begin) {
      same->time.end = time.end;
    } else {
      report_.collisions.push_back({part, tool_->number, time, point});
    }
  }

  /// Mills the interval again, and looks for the cuts after which there are more parts: each by
  /// halving, between a cut with as many as before and one with more.
  Result<void> findSeparations(const StockField& before, const std::vector<Cut>& cuts,
                               std::uint64_t partsAfter) {
    std::uint64_t parts = components_;
    StockField from = before;
    std::size_t done = 0;  // cuts made in `from`, which has no more than `parts`
    while (partsAfter > parts) {
      std::size_t end = cuts.size();  // after these there are more
      std::uint64_t more = partsAfter;
      while (end - done > 1) {
        const std::size_t middle = done + (end - done) / 2;
        StockField field = from;
        for (std::size_t i = done; i < middle; ++i) {
          if (auto removed = field.remove(cuts[i].envelope); !removed) return removed.error();
        }
        const std::uint64_t here = countParts(field);
        if (here > parts) {
          end = middle;
          more = here;
        } else {
          done = middle;
          from = std::move(field);
        }
      }
      if (auto removed = from.remove(cuts[done].envelope); !removed) return removed.error();
      // The voxels lose a wall that is thinner than one; the tool may still have to cut it.
      const TimeSpan& step = cuts[done].time;
      report_.separations.push_back(
          {{step.begin, timeAfterTravel(motion_, step.end, options_.voxelSize)}, more});
      ++done;
      parts = more;
    }
    return {};
  }

  StockField field_;
  voxel4d::Lattice lattice_;
  std::span<const Tool> tools_;
  const Tool* tool_;  // that is mounted
  const model::Motion& motion_;
  const MillOptions& options_;
  double travel_;
  MillReport& report_;
  std::uint64_t components_ = 0;
};

/// The stock as a field that is not empty.
Result<StockField> fieldOf(const TriangleMesh& stock, const MillOptions& options) {
  auto field = StockField::of(stock, options.voxelSize, options.memory);
  if (!field || !field->empty()) return field;
  const model::Bounds3 bounds = model::boundsOf(stock);
  const double least = std::min((bounds.max - bounds.min).minCoeff(), options.voxelSize);
  std::string advice;
  constexpr int kTries = 8;
  double size = least / 4;
  for (int i = 0; i < kTries && advice.empty() && size > 0; ++i, size /= 2) {
    const double digit = std::pow(10, std::floor(std::log10(size)) - 1);
    const double round = std::floor(size / digit) * digit;
    const auto finer = StockField::of(stock, round, options.memory);
    if (!finer) break;
    if (!finer->empty()) advice = fmt::format("; {:.2g} would do", round);
  }
  return fail(ErrorCode::Unsupported,
              fmt::format("with a voxel size of {:g} no lattice point is inside the stock; the "
                          "voxels are too large for it{}",
                          options.voxelSize, advice),
              {}, Remedy::VoxelSize);
}

/// A notice if the voxels have another volume than the mesh.
std::string noticeOfVolume(double voxels, double mesh) {
  constexpr double kMost = 0.05;
  if (std::abs(voxels - mesh) <= kMost * mesh) return {};
  return fmt::format(
      "the stock has a volume of {:.6g} in voxels and of {:.6g} as a mesh; smaller voxels are "
      "nearer to it",
      voxels, mesh);
}

/// A notice if voxels are too large for the groove of the tool.
std::string noticeOfTool(const Tool& tool, double voxelSize) {
  const model::Bounds3 bounds = boundsOf(tool.mesh);
  if ((bounds.max - bounds.min).minCoeff() >= 2 * voxelSize) return {};
  return fmt::format("the {} is less than two voxels across; what it cuts may be lost, or too wide",
                     partOfTool("tool", tool.number));
}

}  // namespace

Mounting mountingOf(std::span<const Tool> tools, double time, std::optional<int> number) {
  if (!number) return {time, std::nullopt};
  const auto tool = std::ranges::find(tools, *number, &Tool::number);
  return {time, static_cast<std::size_t>(tool - tools.begin())};
}

Result<void> checkVoxelSize(const TriangleMesh& stock, double voxelSize, double memory) {
  const auto sized = StockField::sized(stock, voxelSize, memory);
  return sized ? Result<void>() : sized.error();
}

std::string partOfTool(const std::string& part, int number) {
  if (number == 0) return part;
  return fmt::format("{}{}T{}", part, part == "tool" ? " " : " of ", number);
}

Result<MillReport> mill(const TriangleMesh& stock, std::span<const Tool> tools,
                        const model::Motion& motion, const MillOptions& options, model::Sink& sink,
                        const model::Progress& progress) {
  const auto check = [](const TriangleMesh& mesh, const std::string& name) -> Result<void> {
    auto checked = model::checkClosedSurface(mesh);
    if (checked) return checked;
    return invalid(checked.error().text(), name, Remedy::Mend);
  };
  if (auto good = check(stock, "stock"); !good) return good.error();
  for (const Tool& tool : tools) {
    if (auto good = visitSolids(tool, check); !good) return good.error();
  }
  if (options.times.size() < 2 || options.times.front() < motion.timeBegin() ||
      options.times.back() > motion.timeEnd()) {
    return invalid("the frames need two times or more within the motion");
  }
  MillReport report;
  TriangleMesh turned;
  if (model::signedVolume(stock) < 0) {
    turned = stock;
    for (model::Triangle& triangle : turned.triangles) std::swap(triangle[1], triangle[2]);
    report.notices.emplace_back("the stock was inside out and was flipped");
  }
  auto field = fieldOf(turned.triangles.empty() ? stock : turned, options);
  if (!field) return field.error();
  const auto checkSize = [&](const TriangleMesh& mesh, const std::string& name) -> Result<void> {
    auto checked = StockField::checkSize(mesh, options.voxelSize, options.memory);
    if (!checked) checked.error().where = name;
    return checked;
  };
  for (const Tool& tool : tools) {
    if (auto good = visitSolids(tool, checkSize); !good) return good.error();
  }

  if (auto good = checkMotion(tools, motion, *field, options); !good) return good.error();

  Workpiece frames(std::move(*field), tools, motion, options, report);
  std::vector<ProjectedVolume> volumes;
  ProjectedVolumes measured(sink, [&](const ProjectedVolume& one) { volumes.push_back(one); });
  auto woven = voxel4d::weave(frames, {.caps = options.caps}, measured, progress);
  if (!woven) return woven.error();
  report.woven = *woven;
  // A cap, the slabs between frames, a cap.
  report.stockVolume = volumes.front().entries - volumes.front().exits;
  for (std::size_t i = 1; i < report.progress.size(); ++i) {
    // Rounding must not make it negative where nothing was cut.
    report.removedVolume += std::max(0.0, volumes[i].exits - volumes[i].entries);
    report.returnedVolume += volumes[i].entries;
    report.progress[i].removedVolume = report.removedVolume;
  }
  if (auto notice = noticeOfVolume(report.stockVolume, std::abs(model::signedVolume(stock)));
      !notice.empty()) {
    report.notices.push_back(std::move(notice));
  }
  for (const Tool& tool : tools) {
    if (auto notice = noticeOfTool(tool, options.voxelSize); !notice.empty()) {
      report.notices.push_back(std::move(notice));
    }
  }
  report.remainingVolume = report.stockVolume - report.removedVolume;
  report.components = report.progress.back().components;
  return report;
}

}  // namespace t4d::mill
