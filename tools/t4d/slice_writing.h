#pragma once

#include <optional>
#include <span>
#include <vector>

#include "t4d/convert.h"
#include "t4d/surface.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/painting.h"
#include "tools/t4d/slice_write_options.h"

/// The meaning of SliceWriteOptions for the folders that slice and write.
namespace t4d::tools {

class Members;

/// The given times of frames or, without any, 60 that are evenly spaced over the whole time.
std::vector<double> timesOfFrames(const std::vector<double>& given, const Input& input);

/// The velocities of frames, if they are needed; per time unit of the mesh if `timeUnits` is empty.
std::optional<convert::FrameVelocity> frameVelocityOf(const SliceWriteOptions& options,
                                                      std::vector<double> timeUnits);

/// `bounds` are those of all vertices that are written.
formats::GltfEncoding gltfEncodingOf(const SliceWriteOptions& options,
                                     const model::Bounds3& bounds);

/// The largest error of a coordinate; nothing if it is not quantized.
std::optional<double> quantizationErrorOf(const formats::GltfEncoding& encoding);

/// The slicing and writing of frames.
struct FrameLooks {
  formats::MeshWriteOptions write = {};  ///< without a placement
  std::optional<convert::FrameVelocity> velocity = {};
  Painting painting = {};
};

/// `timeUnits` as frameVelocityOf takes it.
Result<FrameLooks> frameLooksOf(const SliceWriteOptions& options, const Input& input,
                                std::span<const double> times, slice::SliceDetail detail,
                                std::vector<double> timeUnits, Observer& observer);

/// Adds what the reports of frames say in the same words, from `light` to `quantization_error`.
void addFrameMembers(Members& members, const convert::FrameSlicesReport& written, bool hasVelocity,
                     const std::optional<ColorRange>& colorRange,
                     const std::optional<double>& quantizationError);
/// Adds the last two of them, which the report of a slice has, too.
void addLooks(Members& members, const std::optional<ColorRange>& colorRange,
              const std::optional<double>& quantizationError);

/// The error that velocities per second of playback need two frames.
Error oneFrameHasNoSpeed();

}  // namespace t4d::tools
