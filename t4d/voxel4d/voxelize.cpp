#include "t4d/voxel4d/voxelize.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "t4d/model/limits.h"
#include "t4d/voxel4d/occupancy.h"
#include "t4d/voxel4d/vdb_frames.h"
#include "t4d/voxel4d/vdb_grid.h"
#include "t4d/voxel4d/vdb_series.h"

namespace t4d::voxel4d {

namespace {

/// A step that misses the last time by less than this fraction of its length reaches it.
constexpr double kStepTolerance = 1e-9;

/// One frame of a solid: its inside points, and its level set unless only the mask is requested.
struct Voxels {
  Frame inside;
  openvdb::FloatGrid::Ptr levelSet;
};

/// A level set's distances, up to three voxels, are float32.
constexpr double kSmallestVoxel = 1e-30;
constexpr double kLargestVoxel = 1e30;

Result<void> checkVoxelSize(double size, bool mask) {
  const double least = mask ? model::kSmallestExtent : kSmallestVoxel;
  const double most = mask ? model::kLargestCoordinate : kLargestVoxel;
  if (size >= least && size <= most) return {};
  return invalid(fmt::format("voxels of {} are requested; {} to {} are possible{}", size, least,
                             most, mask ? "" : " in level sets, whose distances are float32"),
                 {}, Remedy::VoxelSize);
}

Result<Voxels> voxelsOf(const SolidAtTime& solid, double time, const Lattice& lattice, bool mask) {
  if (auto good = checkVoxelSize(lattice.voxelSize, mask); !good) return pass(good.error());
  const auto withTime = [&](Error error) {
    error.message = fmt::format("at time {}: {}", time, error.message);
    return pass(std::move(error));
  };
  auto mesh = solid(time);
  if (!mesh) return pass(mesh.error());
  auto inside = occupancy(*mesh, lattice, time);
  if (!inside) return withTime(inside.error());
  Voxels voxels{std::move(*inside), nullptr};
  if (mask) return voxels;
  try {
    initializeOpenVdb();
    voxels.levelSet = levelSetOf(*mesh, lattice, voxels.inside);
  } catch (const std::exception& exception) {
    return withTime({ErrorCode::Failed, fmt::format("OpenVDB: {}", exception.what()), {}, {}});
  }
  return voxels;
}

class VoxelFrames : public FrameSource {
 public:
  VoxelFrames(SolidAtTime solid, std::vector<double> times, const VoxelizeOptions& options)
      : solid_(std::move(solid)), times_(std::move(times)), mask_(options.mask) {
    lattice_.voxelSize = options.voxelSize;
  }

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return times_.size(); }

  Result<Frame> frame(std::size_t index) override {
    auto voxels = voxelsOf(solid_, times_[index], lattice_, mask_);
    if (!voxels) return pass(voxels.error());
    if (mask_) return std::move(voxels->inside);
    return frameOf({voxels->levelSet, nullptr}, times_[index], {},
                   fmt::format("the solid at time {}", times_[index]));
  }

 private:
  SolidAtTime solid_;
  std::vector<double> times_;
  Lattice lattice_;
  bool mask_;
};

Result<void> checkCount(double count) {
  if (count <= static_cast<double>(kMaxFrames)) return {};
  return invalid(fmt::format("{:.0f} frames; at most {} are allowed", count, kMaxFrames));
}

/// The number of frames at intervals of `when.step`: as many as fit, or `when.count`.
Result<std::uint64_t> countOfSteps(const model::TimeSpan& span, const FrameTimes& when) {
  const double step = *when.step;
  if (!(step > 0) || !std::isfinite(step)) {
    return invalid(
        fmt::format("the time between frames is {}; it must be a positive number", step));
  }
  const double steps = std::floor((span.end - span.begin) / step + kStepTolerance);
  if (auto checked = checkCount(steps + 1); !checked) return pass(checked.error());
  if (!(steps >= 1)) {
    return invalid(fmt::format("the time between frames is {}, but from {} to {} there is only {}",
                               step, span.begin, span.end, span.end - span.begin));
  }
  const auto fitting = static_cast<std::uint64_t>(steps) + 1;
  const std::uint64_t count = when.count.value_or(fitting);
  if (count < 2 || count > fitting) {
    return invalid(
        fmt::format("{} frames are requested, {} apart; from {} to {} there can be 2 to {}", count,
                    step, span.begin, span.end, fitting));
  }
  return count;
}

}  // namespace

Result<std::vector<double>> frameTimes(const model::TimeSpan& span, const FrameTimes& when) {
  std::vector<double> times;
  if (when.step) {
    auto count = countOfSteps(span, when);
    if (!count) return pass(count.error());
    times = model::steppedTimes(span.begin, *when.step, *count);
    times.back() = std::min(times.back(), span.end);
  } else {
    const std::uint64_t count = when.count.value_or(0);
    if (count < 2) return invalid(fmt::format("{} frames; a series needs two or more", count));
    if (auto checked = checkCount(static_cast<double>(count)); !checked) {
      return pass(checked.error());
    }
    times = model::evenTimes(span, count);
  }
  if (!std::is_sorted(times.begin(), times.end(), std::less_equal<>())) {
    return invalid(fmt::format("{} frames from time {} to {} are too close to be told apart",
                               times.size(), span.begin, times.back()));
  }
  return times;
}

SolidAtTime movingSolid(model::TriangleMesh mesh, model::Motion motion) {
  return [mesh = std::move(mesh), motion = std::move(motion)](double time) {
    const model::Pose pose = motion.at(time);
    model::TriangleMesh posed;
    posed.triangles = mesh.triangles;
    posed.vertices.reserve(mesh.vertices.size());
    for (const model::Point3& vertex : mesh.vertices) posed.vertices.push_back(pose(vertex));
    return Result<model::TriangleMesh>(std::move(posed));
  };
}

std::unique_ptr<FrameSource> voxelFrames(SolidAtTime solid, std::vector<double> times,
                                         const VoxelizeOptions& options) {
  return std::make_unique<VoxelFrames>(std::move(solid), std::move(times), options);
}

Result<VoxelSeries> writeVoxelFrames(const SolidAtTime& solid, const std::vector<double>& times,
                                     const VoxelizeOptions& options,
                                     const std::filesystem::path& folder,
                                     const model::Progress& progress,
                                     const std::function<Result<void>()>& beforeRenaming) {
  const Lattice lattice{options.voxelSize, model::Point3::Zero()};
  VoxelSeries series;
  std::optional<VdbSeries> files;
  for (const double time : times) {
    auto voxels = voxelsOf(solid, time, lattice, options.mask);
    if (!voxels) return pass(voxels.error());
    // The folder is not touched before the first frame is known to be valid.
    if (!files) {
      auto created = VdbSeries::create(folder, times.size());
      if (!created) return pass(created.error());
      files.emplace(std::move(*created));
    }
    openvdb::GridBase::Ptr grid = voxels->levelSet;
    if (options.mask) grid = boolGridOf(voxels->inside, lattice);
    grid->setName(options.mask ? "inside" : "surface");
    grid->setCreator("t4d");
    grid->insertMeta(kTimeMetadata, openvdb::DoubleMetadata(time));
    series.files.push_back({files->nextName()});
    auto bytes = files->put(grid, options.voxelSize);
    if (!bytes) return pass(bytes.error());
    series.bytes += *bytes;
    series.files.back().bytes = *bytes;
    const std::uint64_t insidePoints = countInside(voxels->inside);
    series.insidePoints += insidePoints;
    series.emptyFrames += insidePoints == 0 ? 1 : 0;
    series.mostActiveVoxels =
        std::max<std::uint64_t>(series.mostActiveVoxels, grid->activeVoxelCount());
    ++series.frames;
    if (progress) progress(static_cast<double>(series.frames) / static_cast<double>(times.size()));
  }
  if (files) {
    if (auto done = beforeRenaming ? beforeRenaming() : Result<void>(); !done) {
      return pass(done.error());
    }
    if (auto done = files->commit(); !done) return pass(done.error());
  }
  return series;
}

}  // namespace t4d::voxel4d
