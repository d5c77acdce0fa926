#include <stdexcept>
#include <utility>

#include <dlfcn.h>
#include <fmt/format.h>

#include "tools/program/openvdb_functions.h"

/// The functions of t4d::voxel4d that need OpenVDB, as the program links them. They are hidden: the
/// module shares all of the library with the program except these, of which it has its own.
namespace t4d::voxel4d {

namespace fs = std::filesystem;

namespace {

const OpenVdbFunctions& loadModule() {
  // Found by the program's RUNPATH.
  void* const module = dlopen("t4d_openvdb.so", RTLD_NOW | RTLD_LOCAL);
  const void* const functions = module ? dlsym(module, "t4dOpenVdbFunctions") : nullptr;
  if (!functions) {
    const char* const reason = dlerror();  // NOLINT(concurrency-mt-unsafe)
    throw std::runtime_error(
        fmt::format("the part of t4d that uses OpenVDB cannot be loaded: {}; it is installed with "
                    "the program",
                    reason ? reason : "no reason is given"));
  }
  return *static_cast<const OpenVdbFunctions*>(functions);
}

const OpenVdbFunctions& openVdb() {
  static const OpenVdbFunctions& functions = loadModule();
  return functions;
}

}  // namespace

[[gnu::visibility("hidden")]] Result<std::unique_ptr<FrameSource>> openVdbFrames(
    std::span<const fs::path> inputs, const VdbFramesOptions& options) {
  return openVdb().openVdbFrames(inputs, options);
}

[[gnu::visibility("hidden")]] std::unique_ptr<FrameSource> voxelFrames(
    SolidAtTime solid, std::vector<double> times, const VoxelizeOptions& options) {
  return openVdb().voxelFrames(std::move(solid), std::move(times), options);
}

[[gnu::visibility("hidden")]] Result<VoxelSeries> writeVoxelFrames(
    const SolidAtTime& solid, const std::vector<double>& times, const VoxelizeOptions& options,
    const fs::path& folder, const model::Progress& progress,
    const std::function<Result<void>()>& beforeRenaming) {
  return openVdb().writeVoxelFrames(solid, times, options, folder, progress, beforeRenaming);
}

[[gnu::visibility("hidden")]] Result<std::uint64_t> writePointField(const fs::path& path,
                                                                    const PointField& field) {
  return openVdb().writePointField(path, field);
}

}  // namespace t4d::voxel4d
