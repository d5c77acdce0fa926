#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/amount_text.h"
#include "tools/t4d/motion_frames.h"
#include "tools/t4d/sweep_parts.h"

namespace t4d::tools {
namespace {

using model::Point3;
using model::TriangleMesh;
using Bodies = std::vector<formats::AnimatedBody>;

/// A run at a time, as a surface; the two keys about it are kept.
class RunAtTime {
 public:
  RunAtTime(const TriangleMesh& mesh, const model::VertexKeys& keys)
      : mesh_(&mesh), keys_(&keys), before_(mesh.vertices.size()), after_(mesh.vertices.size()) {}

  double begin() const { return keys_->time(0); }
  double end() const { return keys_->time(keys_->count() - 1); }

  Result<void> addTo(TriangleMesh& all, double time) {
    std::uint64_t key = 0;
    for (std::uint64_t past = keys_->count() - 1; past - key > 1;) {
      const std::uint64_t middle = key + (past - key) / 2;
      (keys_->time(middle) <= time ? key : past) = middle;
    }
    if (key_ != key) {
      if (auto read = keys_->positions(key, before_); !read) return read;
      if (auto read = keys_->positions(key + 1, after_); !read) return read;
      key_ = key;
    }
    const double from = keys_->time(key);
    const double fraction = (time - from) / (keys_->time(key + 1) - from);
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (std::size_t i = 0; i < before_.size(); ++i) {
      all.vertices.emplace_back((1 - fraction) * before_[i] + fraction * after_[i]);
    }
    for (const auto& [a, b, c] : mesh_->triangles) {
      all.triangles.push_back({first + a, first + b, first + c});
    }
    return {};
  }

 private:
  const TriangleMesh* mesh_;
  const model::VertexKeys* keys_;
  std::optional<std::uint64_t> key_;
  std::vector<Point3> before_;
  std::vector<Point3> after_;
};

/// The solid of all bodies at a time: a run is there from its beginning on, and the last also at
/// its end.
class UnionAtTime {
 public:
  explicit UnionAtTime(const Bodies& bodies) {
    for (const auto& body : bodies) {
      for (const auto& run : body.runs) runs_.emplace_back(body.mesh, *run);
    }
    for (const RunAtTime& run : runs_) end_ = std::max(end_, run.end());
  }

  Result<TriangleMesh> operator()(double time) {
    TriangleMesh all;
    for (RunAtTime& run : runs_) {
      const bool isThere = run.begin() <= time && (time < run.end() || time == end_);
      if (!isThere || time > run.end()) continue;
      if (auto added = run.addTo(all, time); !added) return added.error();
    }
    return all;
  }

 private:
  std::vector<RunAtTime> runs_;
  double end_ = 0;
};

struct Movement {
  model::TimeSpan time;
  model::Bounds3 bounds;  ///< at all times
  double area = 0;        ///< of all bodies, each at its first time
  double speed = 0;       ///< the largest of a vertex
};

Result<Movement> movementOf(const Bodies& bodies) {
  Movement movement;
  bool isFirst = true;
  for (const auto& body : bodies) {
    std::vector<Point3> before(body.mesh.vertices.size());
    std::vector<Point3> after(before.size());
    for (const auto& run : body.runs) {
      const double begin = run->time(0);
      const double end = run->time(run->count() - 1);
      movement.time.begin = isFirst ? begin : std::min(movement.time.begin, begin);
      movement.time.end = isFirst ? end : std::max(movement.time.end, end);
      isFirst = false;
      if (auto read = run->positions(0, before); !read) return read.error();
      for (const Point3& place : before) movement.bounds.add(place);
      if (&run == &body.runs.front()) {
        movement.area += surfaceArea(TriangleMesh{before, body.mesh.triangles, {}});
      }
      for (std::uint64_t key = 1; key < run->count(); ++key) {
        if (auto read = run->positions(key, after); !read) return read.error();
        const double time = run->time(key) - run->time(key - 1);
        for (std::size_t i = 0; i < after.size(); ++i) {
          movement.bounds.add(after[i]);
          movement.speed = std::max(movement.speed, (after[i] - before[i]).norm() / time);
        }
        std::swap(before, after);
      }
    }
  }
  return movement;
}

/// A number with two digits.
std::uint64_t rounded(double number) {
  const double unit = std::pow(10.0, std::max(0.0, std::floor(std::log10(number)) - 1));
  return static_cast<std::uint64_t>(std::round(number / unit) * unit);
}

/// A note about the expected mesh, before it is made.
std::string expectationOf(const Movement& movement, std::size_t frames, double voxelSize) {
  // Measured for animated figures and robots: a voxel that the surface passes has some ten
  // tetrahedra a step, with three bytes each in the file.
  constexpr double kCellsOfVoxel = 10;
  constexpr double kBytesOfCell = 3;
  const Point3 size = (movement.bounds.max - movement.bounds.min) / voxelSize;
  const double cells =
      kCellsOfVoxel * movement.area / voxelSize / voxelSize * static_cast<double>(frames - 1);
  constexpr double kMost = 1e18;  // more than any file, and within the integers
  if (!(cells < kMost) || !(size.maxCoeff() < kMost)) return {};
  const auto voxels = [&](int axis) {
    return model::grouped(static_cast<std::uint64_t>(std::ceil(size[axis])));
  };
  return fmt::format(
      "a union in {} of {} x {} x {} voxels: some {} tetrahedra, {} in the file; larger voxels "
      "and fewer frames make less",
      model::counted(frames, "frame"), voxels(0), voxels(1), voxels(2),
      model::grouped(rounded(cells)), model::sizeText(rounded(kBytesOfCell * cells)));
}

}  // namespace

Result<SweepReport> sweepUnion(const SweepOptions& options, const SweepInput& input, T4dFile& file,
                               Observer& observer) {
  const auto& moving = std::get<BodiesWithKeys>(input.moving);
  const auto movement = movementOf(moving.bodies);
  if (!movement) return movement.error();
  VoxelMethod how;
  how.voxelSize = input.voxelSize;
  how.caps = options.united->caps;
  voxel4d::FrameTimes when = options.united->times;
  const auto enough = voxel4d::framesWithin(how.voxelSize, movement->speed, movement->time);
  if (!when.count && !when.step) {
    when.count = enough ? std::min(*enough, kUsualFrames) : kUsualFrames;
  }
  auto times = voxel4d::frameTimes(movement->time, when);
  if (!times) return times.error();
  for (const std::string& note : {expectationOf(*movement, times->size(), how.voxelSize),
                                  noticeOfGaps(*times, movement->speed, how.voxelSize, enough)}) {
    if (!note.empty()) observer.note(note);
  }
  auto report = sweepByVoxels(how, UnionAtTime(moving.bodies), std::move(*times), file, observer);
  if (!report) {
    Error error = report.error();
    if (error.where.empty()) error.where = modelOf(options);
    return error;
  }
  report->voxelSize = how.voxelSize;
  std::set<std::string> lost;
  for (const auto& body : moving.bodies) {
    for (const model::Attribute& attribute : body.mesh.attributes) lost.insert(attribute.name);
  }
  if (!lost.empty()) {
    report->losses.push_back(
        fmt::format("{}: a union from voxels has no attributes", fmt::join(lost, ", ")));
  }
  return report;
}

}  // namespace t4d::tools
