#include "tools/t4d/compare_methods.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "platform/kept_inputs.h"
#include "platform/replaceable.h"
#include "platform/temporary_folder.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "tools/t4d/motion_frames.h"

namespace t4d::tools {
namespace {

/// The solid and its motion. Its volume is constant.
struct TrueSolid {
  model::TriangleMesh mesh;
  model::Motion motion;
  std::vector<std::string> losses;  ///< what its file holds and the mesh does not

  double volume() const { return std::abs(signedVolume(mesh)); }
  double hypervolume() const { return volume() * (motion.timeEnd() - motion.timeBegin()); }
};

Result<TrueSolid> readTrueSolid(const MethodsOptions& options, Observer& observer) {
  auto loaded = [&] {
    const auto stage = observer.stage("reading " + options.solid);
    return formats::readTriangleMesh(options.solid);
  }();
  if (!loaded) return loaded.error();
  auto motion = formats::readMotion(options.motion, nullptr, options.table);
  if (!motion) return motion.error();
  return TrueSolid{std::move(loaded->mesh), std::move(*motion), std::move(loaded->losses)};
}

/// The name of the file that a method makes; `voxelSize` is for the voxel method.
std::string madeName(const MethodsOptions& options, std::optional<double> voxelSize) {
  std::string name = std::filesystem::path(options.solid).stem().string();
  name += voxelSize ? "-voxel4d" : "-mesh4d";
  if (voxelSize && options.voxelSizes.size() > 1) name += fmt::format("-{}", *voxelSize);
  return name + ".t4d";
}

/// Makes the mesh of a method; adds what is to be said of its frames.
Result<ComparedFile> makeMesh(const MethodsOptions& options, const TrueSolid& solid,
                              const std::filesystem::path& folder, std::optional<double> voxelSize,
                              const MakeMesh& make, std::vector<std::string>& notes) {
  ComparedFile file;
  file.path = (folder / madeName(options, voxelSize)).string();
  file.mesh.hypervolumeExpected = solid.hypervolume();
  MotionSweep what{options.solid, options.motion, options.table, {}, options.steps};
  if (voxelSize) {
    const std::string& unit = solid.motion.lengthUnit;
    // Who makes the mesh says the same.
    const auto times = motionFrameTimes(options.voxels.times, *voxelSize, solid.mesh, solid.motion,
                                        options.motion, notes);
    if (!times) return times.error();
    file.mesh.name = fmt::format("voxel method, {}{}{}", *voxelSize, unit.empty() ? "" : " ", unit);
    file.mesh.voxelSize = *voxelSize;
    file.mesh.frames = times->size();
    what.voxels = options.voxels;
    what.voxels->voxelSize = *voxelSize;
    what.voxels->times.count = times->size();
  } else {
    file.mesh.name = "mesh method";
  }
  SweepOptions sweep{.what = what, .caps = options.meshCaps};
  sweep.output.path = file.path;
  sweep.output.up = options.up;
  sweep.output.generator = options.generator;
  const auto made = make(sweep);
  if (!made) return made.error();
  file.mesh.seconds = made->seconds;
  file.mesh.peakBytes = made->peakBytes;
  return file;
}

/// The folder for the files: that of the options, or a temporary one.
Result<std::filesystem::path> folderFor(const MethodsOptions& options,
                                        std::optional<platform::TemporaryFolder>& temporary) {
  if (options.folder.empty()) {
    auto created = platform::TemporaryFolder::create();
    if (!created) return created.error();
    return temporary.emplace(std::move(*created)).path();
  }
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) {
    return fail(ErrorCode::Failed, "cannot create the folder: " + error.message(), options.folder);
  }
  return std::filesystem::path(options.folder);
}

}  // namespace

MakeMesh makeHere(Observer& observer) {
  return [&observer](const SweepOptions& options) -> Result<MadeMesh> {
    const auto done = sweep(options, observer);
    if (!done) return done.error();
    observer.noteEach(done->notices);
    return MadeMesh{done->seconds};
  };
}

Result<MethodsReport> compareMethods(const MethodsOptions& options, const CompareOptions& comparing,
                                     const MakeMesh& make, Observer& observer) {
  const platform::KeptInputs kept;
  auto solid = readTrueSolid(options, observer);
  if (!solid) return solid.error();
  std::optional<platform::TemporaryFolder> temporary;
  const auto folder = folderFor(options, temporary);
  if (!folder) return folder.error();

  std::vector<std::optional<double>> sizes = {std::nullopt};  // the mesh method first
  const std::set<double, std::greater<>> unique(options.voxelSizes.begin(),
                                                options.voxelSizes.end());
  sizes.insert(sizes.end(), unique.begin(), unique.end());
  for (const std::optional<double>& size : sizes) {
    const std::string name = madeName(options, size);
    if (auto good = platform::checkReplaceable(*folder, {&name, 1}); !good) return good.error();
  }
  std::vector<std::string> notes;
  std::vector<ComparedFile> files;
  for (const std::optional<double>& size : sizes) {
    auto file = makeMesh(options, *solid, *folder, size, make, notes);
    if (!file) return file.error();
    files.push_back(std::move(*file));
  }
  CompareOptions how = comparing;
  how.volumeExpected = solid->volume();
  auto compared = compare(files.front(), std::span(files).subspan(1), how, observer);
  if (!compared) return compared.error();
  compared->notes.insert(compared->notes.begin(), notes.begin(), notes.end());
  return MethodsReport{std::move(*compared), std::move(solid->losses)};
}

}  // namespace t4d::tools
