#include "tools/verbs/slice_write_options.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "formats/gltf/gltf_writer.h"
#include "tools/verbs/painting.h"

namespace t4d::verbs {

bool SliceWriteOptions::isColoredByAttribute() const {
  return color == "triangle" || color.starts_with(kColorByAttribute);
}

bool isSliceColor(std::string_view text) {
  constexpr std::array<std::string_view, 5> kNames = {"body", "time", "speed", "track", "triangle"};
  return std::ranges::find(kNames, text) != kNames.end() ||
         (text.starts_with(kColorByAttribute) && text.size() > kColorByAttribute.size());
}

Result<void> checkSliceWriteOptions(const SliceWriteOptions& options,
                                    const std::filesystem::path& output) {
  const auto refuse = [](std::string message) {
    return fail(ErrorCode::Options, std::move(message));
  };
  if (!options.color.empty() && !isSliceColor(options.color)) {
    return refuse(
        fmt::format("the colour is '{}', not body, time, speed, track, triangle or attribute:NAME",
                    options.color));
  }
  if (options.normals &&
      !(options.normals->creaseDegrees >= 0 && options.normals->creaseDegrees <= 180)) {
    return refuse(fmt::format("edges of normals are sharper than {} degrees, not 0 to 180",
                              options.normals->creaseDegrees));
  }
  if (options.maxSpeed && !(*options.maxSpeed > 0)) {
    return refuse(fmt::format("the largest speed is {}, not above 0", *options.maxSpeed));
  }
  if (options.maxSpeed && !options.needsVelocity()) {
    return refuse("a largest speed needs velocities or colours by speed");
  }
  if (options.quantizeBits && (*options.quantizeBits < 1 || *options.quantizeBits > 16)) {
    return refuse(fmt::format("coordinates have {} bits, not 1 to 16", *options.quantizeBits));
  }
  const bool encodes = options.quantizeBits || options.meshopt;
  if (output.empty() || !encodes) return {};
  if (!formats::isGltf(output)) return refuse("only glTF is quantized or compressed");
  if (options.meshopt && !formats::hasMeshopt()) {
    return fail(ErrorCode::Unsupported, "this build has no meshoptimizer");
  }
  return {};
}

}  // namespace t4d::verbs
