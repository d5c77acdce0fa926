#include "tools/verbs/slice_writing.h"

#include <limits>

#include "t4d/mesh.h"
#include "tools/verbs/json_text.h"
#include "tools/verbs/material_names.h"
#include "tools/verbs/origin.h"

namespace t4d::verbs {

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

void addFrameMembers(nlohmann::ordered_json& value, const convert::FrameSlicesReport& written,
                     bool hasVelocity, const std::optional<ColorRange>& colorRange,
                     const std::optional<double>& quantizationError) {
  value["light"] = written.light;
  value["distance"] = written.distance;
  value["max_speed"] = nullptr;
  value["clamped"] = nullptr;
  if (hasVelocity) {
    value["max_speed"] = written.maxSpeed;
    value["clamped"] = written.clamped;
  }
  value["color_range"] = orNull(colorRange);
  value["quantization_error"] = orNull(quantizationError);
}

Error oneFrameHasNoSpeed() {
  return {.code = ErrorCode::Options,
          .message = "one frame alone has no speed of playback",
          .remedy = Remedy::MoreFrames};
}

}  // namespace t4d::verbs
