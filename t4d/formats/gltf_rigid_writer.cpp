#include "t4d/formats/gltf_rigid_writer.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/gltf_builder.h"
#include "t4d/formats/gltf_writer.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/written_mesh.h"

namespace t4d::formats {
namespace {

/// Samplers of one animation.
class Channels {
 public:
  Channels(GltfBuilder& builder, const model::Point3& center) : builder_(builder), center_(center) {
    animation_.name = "motion";
  }

  /// From keys and, so that all channels are as long, a last one at `end`.
  Result<void> addMotion(const RigidBody& body, int node, double end) {
    std::vector<float> times;
    std::vector<float> rotations;
    std::vector<float> translations;
    Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
    const auto add = [&](const RigidBody::Key& key, double seconds) {
      const auto time = static_cast<float>(seconds);
      // Times must increase; keys closer than float32 can tell are one moment.
      if (!times.empty() && time <= times.back()) return;
      Eigen::Quaterniond rotation = key.rotation.normalized();
      // The same rotation as its opposite, which is the longer way.
      if (rotation.dot(before) < 0) rotation.coeffs() = -rotation.coeffs();
      before = rotation;
      times.push_back(time);
      for (int i = 0; i < 4; ++i) {
        rotations.push_back(static_cast<float>(rotation.coeffs()[i]));  // x, y, z, w
      }
      for (int i = 0; i < 3; ++i) {
        translations.push_back(static_cast<float>(key.translation[i] - center_[i]));
      }
    };
    for (const RigidBody::Key& key : body.keys) add(key, key.seconds);
    add(body.keys.back(), end);
    if (auto done = this->add(times, rotations, 4, node, "rotation", "LINEAR"); !done) return done;
    return this->add(times, translations, 3, node, "translation", "LINEAR");
  }

  Result<void> addShown(const RigidBody& body, int node, double end) {
    if (body.shown.empty()) return {};
    std::vector<float> times;
    std::vector<float> scales;
    const auto add = [&](double seconds, bool shown) {
      const auto time = static_cast<float>(seconds);
      if (!times.empty() && time <= times.back()) return;
      times.push_back(time);
      scales.insert(scales.end(), 3, shown ? 1.0F : 0.0F);
    };
    for (const auto& [seconds, shown] : body.shown) add(seconds, shown);
    add(end, body.shown.back().second);
    return this->add(times, scales, 3, node, "scale", "STEP");
  }

  void finish() {
    if (!animation_.channels.empty()) builder_.model().animations.push_back(std::move(animation_));
  }

 private:
  Result<void> add(const std::vector<float>& times, const std::vector<float>& values,
                   int components, int node, const char* path, const char* interpolation) {
    const auto input = builder_.addFloats(times, 1, true, 0);
    if (!input) return pass(input.error());
    const auto output = builder_.addFloats(values, components, false, 0);
    if (!output) return pass(output.error());
    tinygltf::AnimationSampler sampler;
    sampler.input = *input;
    sampler.output = *output;
    sampler.interpolation = interpolation;
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation_.samplers.size());
    channel.target_node = node;
    channel.target_path = path;
    animation_.samplers.push_back(std::move(sampler));
    animation_.channels.push_back(std::move(channel));
    return {};
  }

  GltfBuilder& builder_;
  const model::Point3& center_;
  tinygltf::Animation animation_;
};

Result<void> addBodies(std::span<const RigidBody> bodies, double seconds,
                       const model::Point3& center, GltfBuilder& builder) {
  Channels channels(builder, center);
  for (const RigidBody& body : bodies) {
    if (body.keys.empty()) return invalid(fmt::format("body '{}' has no keys", body.mesh.name));
    for (const RigidBody::Key& key : body.keys) {
      const bool isFloat =
          ((key.translation - center).array().abs() <= std::numeric_limits<float>::max()).all();
      if (isFloat && key.rotation.coeffs().allFinite()) continue;
      return invalid(
          fmt::format("body '{}' moves beyond the float32 numbers of glTF", body.mesh.name));
    }
    const auto mesh = builder.addMesh(body.mesh, model::Point3::Zero());
    if (!mesh) return pass(mesh.error());
    if (*mesh < 0) continue;
    tinygltf::Node node;
    node.name = body.mesh.name;
    node.mesh = *mesh;
    // At rest, the first key.
    const RigidBody::Key& first = body.keys.front();
    const Eigen::Quaterniond rotation = first.rotation.normalized();
    const model::Point3 place = first.translation - center;
    node.rotation = {rotation.x(), rotation.y(), rotation.z(), rotation.w()};
    node.translation = {place.x(), place.y(), place.z()};
    if (!body.shown.empty() && !body.shown.front().second) node.scale = {0, 0, 0};
    const int index = builder.addNode(std::move(node));
    if (auto done = channels.addMotion(body, index, seconds); !done) return done;
    if (auto done = channels.addShown(body, index, seconds); !done) return done;
  }
  channels.finish();
  return {};
}

}  // namespace

Result<std::vector<std::string>> writeRigidAnimation(const std::filesystem::path& path,
                                                     std::span<const RigidBody> bodies,
                                                     double seconds,
                                                     const MeshWriteOptions& options) {
  if (!isGltf(path)) {
    return fail(ErrorCode::Unsupported,
                "unsupported output extension; an animation is written as .glb or .gltf",
                path.string());
  }
  const bool binary = lowerCaseExtension(path) == ".glb";
  MeshWriteOptions how = options;
  how.attributes = false;
  auto builder =
      GltfBuilder::create(binary ? GltfBuilder::Form::Binary : GltfBuilder::Form::Text, how, {});
  if (!builder) return inFile(path, builder.error());
  auto file = OutputFile::create(path);
  if (!file) return pass(file.error());
  if (auto done = addBodies(bodies, seconds, options.center, *builder); !done) {
    return inFile(path, done.error());
  }
  auto lost = builder->finish(*file);
  if (!lost) return inFile(path, lost.error());
  if (auto done = file->commit(); !done) return pass(done.error());
  return lost;
}

}  // namespace t4d::formats
