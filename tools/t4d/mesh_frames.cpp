#include "tools/t4d/mesh_frames.h"

#include <algorithm>

#include <fmt/format.h>

#include "convert/frame_slices.h"
#include "formats/animation/mesh_steps.h"
#include "formats/numbered_files.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/mesh.h"
#include "voxel4d/frame_spacing.h"
#include "voxel4d/occupancy.h"

namespace t4d::tools {
namespace {

/// Reads one mesh, and notes in the log what is said of it.
class MeshSeries {
 public:
  MeshSeries(std::vector<formats::MeshStep> steps, std::vector<double> times, double voxelSize,
             std::shared_ptr<MeshFramesLog> log)
      : steps_(std::move(steps)),
        times_(std::move(times)),
        lattice_{voxelSize, model::Point3::Zero()},
        log_(std::move(log)) {}

  Result<model::TriangleMesh> at(double time) {
    const auto index = std::ranges::lower_bound(times_, time) - times_.begin();
    const formats::MeshStep& step = steps_[static_cast<std::size_t>(index)];
    const std::filesystem::path& file = step.files.front();
    auto loaded = formats::readMeshStep(step);
    if (!loaded) return loaded.error();
    if (auto good = voxel4d::checkVoxelizable(loaded->mesh, lattice_); !good) {
      Error error = good.error();
      if (error.where.empty()) error.where = file.string();
      return error;
    }
    note(*loaded, file.filename().string());
    return std::move(loaded->mesh);
  }

 private:
  void note(const formats::LoadedMesh& loaded, const std::string& name) {
    for (const std::string& loss : loaded.losses) {
      if (std::ranges::find(log_->losses, loss) == log_->losses.end()) log_->losses.push_back(loss);
    }
    for (const auto& file : loaded.otherFiles) log_->files.push_back(file.string());
    // A note for each of a thousand meshes would hide all others.
    if (!loaded.notices.empty() && !mended_) {
      mended_ = true;
      for (const std::string& notice : loaded.notices) {
        log_->notices.push_back(fmt::format("{}: {}; others may have had the same", name, notice));
      }
    }
    const model::Bounds3 bounds = boundsOf(loaded.mesh);
    const double narrowest = (bounds.max - bounds.min).minCoeff();
    if (lattice_.voxelSize > narrowest && !narrow_) {
      narrow_ = true;
      log_->notices.push_back(fmt::format(
          "voxels of {} are larger than the solid of {}, which is {:.4g} wide: it may fall between "
          "lattice points",
          lattice_.voxelSize, name, narrowest));
    }
  }

  std::vector<formats::MeshStep> steps_;
  std::vector<double> times_;
  voxel4d::Lattice lattice_;
  std::shared_ptr<MeshFramesLog> log_;
  bool mended_ = false;
  bool narrow_ = false;
};

}  // namespace

bool isMeshFrame(const std::string& path) {
  if (formats::isCollection(path)) return true;
  const auto* format = formats::triangleMeshFormat(path);
  return format != nullptr && format->read != nullptr;
}

Result<MeshFrames> openMeshFrames(const std::vector<std::string>& files,
                                  const MeshFramesOptions& options) {
  const std::vector<std::filesystem::path> paths(files.begin(), files.end());
  if (options.times.empty()) {
    if (auto whole = formats::checkNumbers(paths); !whole) return whole.error();
  }
  auto series = formats::meshSteps(paths);
  if (!series) return series.error();
  const std::string first = series->steps.front().files.front().string();
  std::vector<double> times;
  if (!options.times.empty()) {
    if (auto good = voxel4d::checkFrameTimes(options.times, series->steps.size()); !good) {
      return invalid(good.error().message, first);
    }
    times = options.times;
  } else if (series->timed && !options.frameTime) {
    for (const formats::MeshStep& step : series->steps) times.push_back(step.time);
  } else {
    const double step = options.frameTime.value_or(1);
    times = model::steppedTimes(options.startTime, step, series->steps.size());
    if (!std::ranges::is_sorted(times, std::less_equal<>())) {
      return invalid(fmt::format("frames {} apart from time {} on are too close to be told apart",
                                 step, options.startTime),
                     first, Remedy::FrameTime);
    }
  }
  MeshFrames opened{nullptr, std::make_shared<MeshFramesLog>()};
  if (!options.frameTime && options.times.empty() && !series->timed) {
    opened.log->notices.emplace_back(kMeshesAreOneApart);
  }
  voxel4d::VoxelizeOptions voxels{options.voxelSize};
  for (const formats::MeshStep& step : series->steps) {
    for (const auto& file : step.files) opened.log->files.push_back(file.string());
    voxels.places.emplace_back(step.files.front().string());
  }
  auto meshes =
      std::make_shared<MeshSeries>(std::move(series->steps), times, options.voxelSize, opened.log);
  opened.frames = voxel4d::voxelFrames([meshes](double time) { return meshes->at(time); },
                                       std::move(times), voxels);
  return opened;
}

}  // namespace t4d::tools
