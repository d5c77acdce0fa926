#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/gltf_writer.h"
#include "t4d/model/body.h"

namespace t4d::convert {

struct FlipbookReport {
  std::uint64_t frames = 0;
  std::uint64_t triangles = 0;      ///< in all frames together
  std::vector<std::string> losses;  ///< as formats::writeTriangleMeshes
};

/// Writes the solids at `times` as one animated glTF (formats::FlipbookWriter). A body that does
/// not exist at a time is left out of that frame. Times are interpreted as in sliceAtTime. Fails if
/// no body has a slab, if there are no times, and for a time before or after all bodies.
Result<FlipbookReport> writeFlipbook(std::span<const model::Body> bodies,
                                     std::span<const double> times,
                                     const std::filesystem::path& path, double framesPerSecond,
                                     const formats::MeshWriteOptions& options = {},
                                     const model::Progress& progress = {});

}  // namespace t4d::convert
