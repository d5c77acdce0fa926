#include "formats/gltf/gltf_channels.h"

#include "formats/file_extension.h"
#include "formats/gltf/gltf_writer.h"
#include "formats/triangle/written_mesh.h"

namespace t4d::formats {

Result<GltfBuilder> animationBuilder(const std::filesystem::path& path,
                                     const MeshWriteOptions& options) {
  if (!isGltf(path)) {
    return fail(ErrorCode::Unsupported,
                "unsupported output extension; an animation is written as .glb or .gltf",
                path.string());
  }
  const bool binary = lowerCaseExtension(path) == ".glb";
  auto builder =
      GltfBuilder::create(binary ? GltfBuilder::Form::Binary : GltfBuilder::Form::Text, options);
  if (!builder) return inFile(path, builder.error());
  return builder;
}

Result<void> GltfChannels::add(int node, const char* path, const char* interpolation,
                               std::span<const float> seconds, int values) {
  const auto input = builder_.addFloats(seconds, 1, true, 0);
  if (!input) return input.error();
  tinygltf::AnimationSampler sampler;
  sampler.input = *input;
  sampler.output = values;
  sampler.interpolation = interpolation;
  tinygltf::AnimationChannel channel;
  channel.sampler = static_cast<int>(animation_.samplers.size());
  channel.target_node = node;
  channel.target_path = path;
  animation_.samplers.push_back(std::move(sampler));
  animation_.channels.push_back(std::move(channel));
  return {};
}

Result<void> GltfChannels::addShown(int node, std::span<const std::pair<double, bool>> shown,
                                    double end) {
  if (shown.empty()) return {};
  std::vector<float> times;
  std::vector<float> scales;
  const auto add = [&](double seconds, bool visible) {
    const auto time = static_cast<float>(seconds);
    if (!times.empty() && time <= times.back()) return;
    times.push_back(time);
    scales.insert(scales.end(), 3, visible ? 1.0F : 0.0F);
  };
  for (const auto& [seconds, visible] : shown) add(seconds, visible);
  add(end, shown.back().second);
  const auto values = builder_.addFloats(scales, 3, false, 0);
  if (!values) return values.error();
  return this->add(node, "scale", "STEP", times, *values);
}

void GltfChannels::finish() {
  if (!animation_.channels.empty()) builder_.model().animations.push_back(std::move(animation_));
}

}  // namespace t4d::formats
