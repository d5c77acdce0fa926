#include "tools/program/gltf_options.h"

#include <fmt/format.h>

#include "t4d/formats/gltf/gltf_writer.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {

void GltfOptions::addTo(CLI::App& command) {
  command
      .add_option("--quantize", bits,
                  "Bits per coordinate in glTF (KHR_mesh_quantization); 8 for normals")
      ->check(wholeNumber(1, 16));
  command.add_flag("--meshopt", meshopt,
                   "Compress glTF losslessly (EXT_meshopt_compression; not for Blender)");
}

std::optional<std::string> GltfOptions::misuse(const std::filesystem::path& output) const {
  if (!bits && !meshopt) return std::nullopt;
  const char* option = bits ? "--quantize" : "--meshopt";
  if (!formats::isGltf(output))
    return fmt::format("{}: only .glb and .gltf are encoded so", option);
  if (meshopt && !formats::hasMeshopt()) {
    return "--meshopt: this program was built without meshoptimizer";
  }
  return std::nullopt;
}

formats::GltfEncoding GltfOptions::encoding(const model::Bounds3& bounds) const {
  formats::GltfEncoding made;
  made.meshopt = meshopt;
  if (!bits) return made;
  const model::Point3 origin = model::Point3::Zero();
  made.quantization = {static_cast<int>(*bits),
                       bounds.empty() ? model::Bounds3{origin, origin} : bounds};
  return made;
}

std::string quantizationText(const formats::GltfEncoding& encoding) {
  if (!encoding.quantization) return {};
  return fmt::format("coordinates in {} bits, each within {:.3g}", encoding.quantization->bits,
                     encoding.quantization->step() / 2);
}

nlohmann::json quantizationError(const formats::GltfEncoding& encoding) {
  if (!encoding.quantization) return nullptr;
  return encoding.quantization->step() / 2;
}

}  // namespace t4d::tools
