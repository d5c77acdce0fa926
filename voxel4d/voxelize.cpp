#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "model/progress.h"
#include "model/voxel_size.h"
#include "t4d/frames.h"
#include "t4d/weave.h"
#include "voxel4d/frame_parts.h"
#include "voxel4d/occupancy.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_series.h"
#include "voxel4d/vdb_voxel.h"

namespace t4d::voxel4d {

namespace {

/// One frame of a solid: its inside points, and its level set unless only the mask is requested.
struct Voxels {
  Frame inside;
  openvdb::FloatGrid::Ptr levelSet;
};

Result<Voxels> voxelsOf(const SolidAtTime& solid, double time, const Lattice& lattice, bool mask) {
  if (auto good = model::checkVoxelSize(lattice.voxelSize); !good) return good.error();
  const auto withTime = [&](Error error) {
    error.message = fmt::format("at time {}: {}", time, error.message);
    return error;
  };
  auto mesh = solid(time);
  if (!mesh) return mesh.error();
  auto occupancy = occupancyOf(*mesh, lattice, time);
  if (!occupancy) return withTime(occupancy.error());
  Voxels voxels;
  if (mask) {
    voxels.inside = std::move(occupancy->inside);
    return voxels;
  }
  try {
    initializeOpenVdb();
    voxels.levelSet = levelSetOf(*occupancy, lattice);
  } catch (const std::exception& exception) {
    return withTime({ErrorCode::Failed, fmt::format("OpenVDB: {}", exception.what()), {}, {}});
  }
  voxels.inside = std::move(occupancy->inside);
  return voxels;
}

class VoxelFrames : public FrameSource {
 public:
  VoxelFrames(SolidAtTime solid, std::vector<double> times, const VoxelizeOptions& options)
      : solid_(std::move(solid)),
        times_(std::move(times)),
        mask_(options.mask),
        places_(options.places) {
    lattice_.voxelSize = options.voxelSize;
  }

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return times_.size(); }
  Place placeOf(std::size_t index) const override {
    return places_.empty() ? FrameSource::placeOf(index) : places_[index];
  }

  Result<Frame> frame(std::size_t index) override {
    auto voxels = voxelsOf(solid_, times_[index], lattice_, mask_);
    if (!voxels) {
      Error error = voxels.error();
      if (error.where.empty() && !places_.empty()) error.where = places_[index];
      return error;
    }
    if (mask_) return std::move(voxels->inside);
    return frameOf({voxels->levelSet, nullptr}, times_[index], {},
                   fmt::format("the solid at time {}", times_[index]));
  }

 private:
  SolidAtTime solid_;
  std::vector<double> times_;
  Lattice lattice_;
  bool mask_;
  std::vector<Place> places_;
};

}  // namespace

std::unique_ptr<FrameSource> voxelFrames(SolidAtTime solid, std::vector<double> times,
                                         const VoxelizeOptions& options) {
  return std::make_unique<VoxelFrames>(std::move(solid), std::move(times), options);
}

Result<VoxelSeries> writeVoxelFrames(const SolidAtTime& solid, const std::vector<double>& times,
                                     const VoxelizeOptions& options,
                                     const std::filesystem::path& folder,
                                     const model::Progress& progress,
                                     const std::function<Result<void>()>& beforeRenaming) {
  if (auto good = checkVdbVoxel(options.voxelSize); !good) return good.error();
  const Lattice lattice{options.voxelSize, model::Point3::Zero()};
  VoxelSeries series;
  std::optional<VdbSeries> files;
  IndexedFrame before;
  FrameParts partsBefore;
  const auto putFrame = [&](const Voxels& voxels, double time) -> Result<void> {
    // The folder is not touched before the first frame is known to be valid.
    if (!files) {
      auto created = VdbSeries::create(folder, times.size(), options.part);
      if (!created) return created.error();
      files.emplace(std::move(*created));
    }
    openvdb::GridBase::Ptr grid = voxels.levelSet;
    if (options.mask) grid = boolGridOf(voxels.inside, lattice);
    grid->setName(options.mask ? "inside" : "surface");
    grid->setCreator("t4d");
    grid->insertMeta(kTimeMetadata, openvdb::DoubleMetadata(time));
    series.files.push_back({files->nextName()});
    auto bytes = files->put(grid);
    if (!bytes) return bytes.error();
    series.bytes += *bytes;
    series.files.back().bytes = *bytes;
    const std::uint64_t insidePoints = countInside(voxels.inside);
    series.insidePoints += insidePoints;
    series.emptyFrames += insidePoints == 0 ? 1 : 0;
    series.mostActiveVoxels =
        std::max<std::uint64_t>(series.mostActiveVoxels, grid->activeVoxelCount());
    ++series.frames;
    return {};
  };
  const model::PartRange own = options.part.of(times.size());
  const std::uint64_t last = std::min<std::uint64_t>(own.end + 1, times.size());
  for (std::uint64_t i = own.begin; i < last; ++i) {
    const double time = times[i];
    const bool isOwn = i < own.end;
    auto voxels = voxelsOf(solid, time, lattice, options.mask || !isOwn);
    if (!voxels) return voxels.error();
    if (isOwn) {
      if (auto put = putFrame(*voxels, time); !put) return put.error();
    }
    IndexedFrame after(std::move(voxels->inside));
    FrameParts partsAfter(after);
    if (i > own.begin) {
      addPartsLost(before, partsBefore, after, partsAfter, i - 1, lattice.place(),
                   series.partsLost);
    }
    before = std::move(after);
    partsBefore = std::move(partsAfter);
    if (!isOwn) continue;
    if (auto on = model::report(progress, series.frames, own.size()); !on) return on.error();
  }
  if (files) {
    if (auto done = beforeRenaming ? beforeRenaming() : Result<void>(); !done) {
      return done.error();
    }
    if (auto done = files->commit(); !done) return done.error();
  }
  return series;
}

}  // namespace t4d::voxel4d
