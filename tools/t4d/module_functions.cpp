#include <stdexcept>
#include <utility>

#include <dlfcn.h>
#include <fmt/format.h>

#include "tools/t4d/modules.h"

namespace t4d {
namespace {

#ifdef T4D_STATIC
template <class Functions>
const Functions& loaded() {
  throw std::runtime_error(
      fmt::format("this is the static program, which has no {}; the package of t4d has it",
                  Functions::kModule));
}
#else
template <class Functions>
const Functions& loaded() {
  // Found by the program's RUNPATH.
  void* const module = dlopen(Functions::kModule, RTLD_NOW | RTLD_LOCAL);
  const void* const table = module ? dlsym(module, Functions::kTable) : nullptr;
  if (!table) {
    const char* const reason = dlerror();  // NOLINT(concurrency-mt-unsafe)
    throw std::runtime_error(
        fmt::format("a part of t4d cannot be loaded: {}; it is installed with "
                    "the program",
                    reason ? reason : "no reason is given"));
  }
  return *static_cast<const Functions*>(table);
}
#endif

template <class Functions>
const Functions& functionsOf() {
  static const Functions& functions = loaded<Functions>();
  return functions;
}

}  // namespace

// They are hidden: the modules share all of the library with the program except these, of which
// they have their own.

namespace voxel4d {

namespace fs = std::filesystem;

[[gnu::visibility("hidden")]] Result<std::unique_ptr<FrameSource>> openVdbFrames(
    std::span<const fs::path> inputs, const VdbFramesOptions& options) {
  return functionsOf<OpenVdbFunctions>().openVdbFrames(inputs, options);
}

[[gnu::visibility("hidden")]] std::unique_ptr<FrameSource> advectedFrames(
    std::unique_ptr<FrameSource> frames, std::unique_ptr<VelocitySource> velocities,
    std::uint32_t substeps) {
  return functionsOf<OpenVdbFunctions>().advectedFrames(std::move(frames), std::move(velocities),
                                                        substeps);
}

[[gnu::visibility("hidden")]] std::unique_ptr<FrameSource> voxelFrames(
    SolidAtTime solid, std::vector<double> times, const VoxelizeOptions& options) {
  return functionsOf<OpenVdbFunctions>().voxelFrames(std::move(solid), std::move(times), options);
}

[[gnu::visibility("hidden")]] Result<VoxelSeries> writeVoxelFrames(
    const SolidAtTime& solid, const std::vector<double>& times, const VoxelizeOptions& options,
    const fs::path& folder, const model::Progress& progress,
    const std::function<Result<void>()>& beforeRenaming) {
  return functionsOf<OpenVdbFunctions>().writeVoxelFrames(solid, times, options, folder, progress,
                                                          beforeRenaming);
}

[[gnu::visibility("hidden")]] Result<std::uint64_t> writePointField(const fs::path& path,
                                                                    const PointField& field) {
  return functionsOf<OpenVdbFunctions>().writePointField(path, field);
}

[[gnu::visibility("hidden")]] Result<JoinedField> joinPointFields(std::span<const fs::path> parts,
                                                                  const fs::path& path) {
  return functionsOf<OpenVdbFunctions>().joinPointFields(parts, path);
}

}  // namespace voxel4d

namespace formats {

/// Replaces the library's function, which needs libcurl from the start.
[[gnu::visibility("hidden")]] void readUrls() {
#ifdef T4D_WITH_CURL
  setUrlOpener([](const std::string& url) {
    return functionsOf<WebFunctions>().openHttpSource(url, HttpTimeouts{});
  });
#endif
}

}  // namespace formats

#ifdef T4D_WITH_RSVG
namespace tools {

[[gnu::visibility("hidden")]] Result<std::string> pngOfSvg(const std::string& svg,
                                                           double pixelsPerUnit) {
  return functionsOf<PictureFunctions>().pngOfSvg(svg, pixelsPerUnit);
}

}  // namespace tools
#endif

}  // namespace t4d
