#include "tools/t4d/slice_writing.h"

#include <limits>

#include "t4d/mesh.h"
#include "tools/t4d/material_names.h"
#include "tools/t4d/members.h"
#include "tools/t4d/origin.h"

namespace t4d::tools {

std::vector<double> timesOfFrames(const std::vector<double>& given, const Input& input) {
  constexpr std::uint64_t kFramesByDefault = 60;
  return given.empty() ? model::evenTimes(model::timeSpanOf(input.bodies), kFramesByDefault)
                       : given;
}

std::optional<convert::FrameVelocity> frameVelocityOf(const SliceWriteOptions& options,
                                                      std::vector<double> timeUnits) {
  if (!options.needsVelocity()) return std::nullopt;
  return convert::FrameVelocity{options.maxSpeed.value_or(std::numeric_limits<double>::infinity()),
                                std::move(timeUnits), options.velocity};
}

formats::GltfEncoding gltfEncodingOf(const SliceWriteOptions& options,
                                     const model::Bounds3& bounds) {
  formats::GltfEncoding made;
  made.meshopt = options.meshopt;
  if (!options.quantizeBits) return made;
  const model::Point3 origin = model::Point3::Zero();
  made.quantization = {static_cast<int>(*options.quantizeBits),
                       bounds.empty() ? model::Bounds3{origin, origin} : bounds};
  return made;
}

std::optional<double> quantizationErrorOf(const formats::GltfEncoding& encoding) {
  if (!encoding.quantization) return std::nullopt;
  return encoding.quantization->step() / 2;
}

Result<FrameLooks> frameLooksOf(const SliceWriteOptions& options, const Input& input,
                                std::span<const double> times, slice::SliceDetail detail,
                                std::vector<double> timeUnits, Observer& observer) {
  FrameLooks looks;
  looks.velocity = frameVelocityOf(options, std::move(timeUnits));
  auto painting = paintingOfFrames(options, input, times, detail, looks.velocity, observer);
  if (!painting) return inInput(painting.error(), input);
  looks.painting = std::move(*painting);
  const auto bounds = boundsOf(input);
  if (!bounds) return inInput(bounds.error(), input);
  looks.write.attributes = options.attributes;
  looks.write.materials = materialNamesOf(input.metadata);
  looks.write.normals = options.normals;
  looks.write.gltf = gltfEncodingOf(options, *bounds);
  looks.write.origin = originOf(input.metadata);
  if (options.center) looks.write.center = roundCenterOf(*bounds);
  return looks;
}

void addFrameMembers(Members& members, const convert::FrameSlicesReport& written, bool hasVelocity,
                     const std::optional<ColorRange>& colorRange,
                     const std::optional<double>& quantizationError) {
  const auto ofVelocity = [&]<class T>(const T& value) {
    return hasVelocity ? std::optional<T>(value) : std::nullopt;
  };
  members("light", written.light,
          "Whether all slices, in all bodies, have the triangles of the layers (light slices).")
      .joined(Joined::All);
  members("distance", written.distance,
          "Bound on the Hausdorff distance of what is shown from the exact slice, in length units, "
          "the largest of all frames; 0 if all are exact, null if it is too large for a double.")
      .atLeast(0)
      .orNull()
      .joined(Joined::Most);
  members(
      "max_speed", ofVelocity(written.maxSpeed),
      "Largest speed of a vertex, as written, in length units per time unit of the mesh, or per "
      "second of playback; null without velocities.")
      .atLeast(0)
      .joined(Joined::Most);
  members("clamped", ofVelocity(written.clamped),
          "Number of vertices that --max-speed slowed down, in all frames together; null without "
          "velocities.")
      .joined(Joined::Added);
  addLooks(members, colorRange, quantizationError);
}

void addLooks(Members& members, const std::optional<ColorRange>& colorRange,
              const std::optional<double>& quantizationError) {
  members("color_range", colorRange,
          "Smallest and largest value of the attribute that gives the colours, the ends of the "
          "colour map; null if colours do not come from numbers.")
      .joined(Joined::First);
  members("quantization_error", quantizationError,
          "Maximum error of a quantized coordinate, in the units of the slice's axes; null if "
          "coordinates are not quantized.")
      .atLeast(0)
      .joined(Joined::Most);
}

Error oneFrameHasNoSpeed() {
  return {.code = ErrorCode::Options,
          .message = "one frame alone has no speed of playback",
          .remedy = Remedy::MoreFrames};
}

}  // namespace t4d::tools
