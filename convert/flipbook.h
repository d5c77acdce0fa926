#pragma once

#include <filesystem>
#include <span>

#include "convert/frame_slices.h"
#include "formats/gltf/gltf_writer.h"
#include "model/attribute_meaning.h"
#include "model/body.h"

namespace t4d::convert {

struct FlipbookOptions {
  double framesPerSecond = 24;
  slice::SliceDetail detail = slice::SliceDetail::Light;
  formats::MeshWriteOptions write = {};
  Paint paint = {};
  std::optional<FrameVelocity> velocity = {};
  model::AttributeMeanings meanings = {};  ///< of attributes of bodies that move or morph
};

/// The first check of every kind of flipbook. Fails if checkFrameTimes does, and for a rate that is
/// not positive and finite.
Result<void> checkFlipbook(std::span<const model::Body> bodies, std::span<const double> times,
                           const FlipbookOptions& options);

/// Writes the solids at `times` as one animated glTF (formats::FlipbookWriter) or, depending on the
/// extension, USD (formats::UsdWriter). `losses` of the report include those of
/// formats::writeTriangleMeshes. Fails if forEachFrame or the writer does.
Result<FrameSlicesReport> writeFlipbook(std::span<const model::Body> bodies,
                                        std::span<const double> times,
                                        const std::filesystem::path& path,
                                        const FlipbookOptions& options = {},
                                        const model::Progress& progress = {});

}  // namespace t4d::convert
