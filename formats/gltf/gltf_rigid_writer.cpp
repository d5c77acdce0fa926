#include "formats/gltf/gltf_rigid_writer.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "formats/gltf/gltf_builder.h"
#include "formats/gltf/gltf_channels.h"
#include "formats/output_file.h"
#include "formats/triangle/written_mesh.h"

namespace t4d::formats {
namespace {

/// Adds channels from the keys and, so that all channels are as long, a last one at `end`.
Result<void> addMotion(const RigidBody& body, int node, double end, const model::Point3& center,
                       GltfBuilder& builder, GltfChannels& channels) {
  std::vector<float> times;
  std::vector<float> rotations;
  std::vector<float> translations;
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  const auto add = [&](const RigidBody::Key& key, double seconds) {
    const auto time = static_cast<float>(seconds);
    // Times must increase; keys closer than float32 can tell are one moment.
    if (!times.empty() && time <= times.back()) return;
    Eigen::Quaterniond rotation = key.rotation.normalized();
    // Of q and -q, which are the same rotation, take the one closer to the key before.
    if (rotation.dot(before) < 0) rotation.coeffs() = -rotation.coeffs();
    before = rotation;
    times.push_back(time);
    for (int i = 0; i < 4; ++i) {
      rotations.push_back(static_cast<float>(rotation.coeffs()[i]));  // x, y, z, w
    }
    for (int i = 0; i < 3; ++i) {
      translations.push_back(static_cast<float>(key.translation[i] - center[i]));
    }
  };
  for (const RigidBody::Key& key : body.keys) add(key, key.seconds);
  add(body.keys.back(), end);
  const auto turns = builder.addFloats(rotations, 4, false, 0);
  if (!turns) return turns.error();
  if (auto done = channels.add(node, "rotation", "LINEAR", times, *turns); !done) return done;
  const auto moves = builder.addFloats(translations, 3, false, 0);
  if (!moves) return moves.error();
  return channels.add(node, "translation", "LINEAR", times, *moves);
}

Result<void> addBodies(std::span<const RigidBody> bodies, double seconds,
                       const model::Point3& center, GltfBuilder& builder) {
  GltfChannels channels(builder, "motion");
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
    if (!mesh) return mesh.error();
    if (*mesh < 0) continue;
    tinygltf::Node node;
    node.name = body.mesh.name;
    node.mesh = *mesh;
    // The node at rest has the first key.
    const RigidBody::Key& first = body.keys.front();
    const Eigen::Quaterniond rotation = first.rotation.normalized();
    const model::Point3 place = first.translation - center;
    node.rotation = {rotation.x(), rotation.y(), rotation.z(), rotation.w()};
    node.translation = {place.x(), place.y(), place.z()};
    if (!body.shown.empty() && !body.shown.front().second) node.scale = {0, 0, 0};
    const int index = builder.addNode(std::move(node));
    if (auto done = addMotion(body, index, seconds, center, builder, channels); !done) return done;
    if (auto done = channels.addShown(index, body.shown, seconds); !done) return done;
  }
  channels.finish();
  return {};
}

}  // namespace

Result<std::vector<std::string>> writeRigidAnimation(const std::filesystem::path& path,
                                                     std::span<const RigidBody> bodies,
                                                     double seconds,
                                                     const MeshWriteOptions& options) {
  auto builder = animationBuilder(path, options);
  if (!builder) return builder.error();
  if (options.gltf.quantization) {
    return fail(ErrorCode::Unsupported, "quantized positions of bodies that are moved by poses",
                path.string());
  }
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  if (auto done = addBodies(bodies, seconds, options.center, *builder); !done) {
    return inFile(path, done.error());
  }
  auto lost = builder->finish(*file);
  if (!lost) return inFile(path, lost.error());
  if (auto done = file->commit(); !done) return done.error();
  return lost;
}

}  // namespace t4d::formats
