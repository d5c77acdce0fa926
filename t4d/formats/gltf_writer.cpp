#include "t4d/formats/gltf_writer.h"

#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/gltf_builder.h"
#include "t4d/formats/written_mesh.h"

namespace t4d::formats {

namespace {

using Form = GltfBuilder::Form;

Result<std::vector<std::string>> writeScene(Form form, OutputFile& file,
                                            std::span<const NamedMesh> meshes,
                                            const MeshWriteOptions& options) {
  auto builder = GltfBuilder::create(form, options, {});
  if (!builder) return pass(builder.error());
  for (const NamedMesh& named : meshes) {
    const auto mesh = builder->addMesh(named);
    if (!mesh) return pass(mesh.error());
    if (*mesh < 0) continue;
    tinygltf::Node node;
    node.name = named.name;
    node.mesh = *mesh;
    builder->addNode(std::move(node));
  }
  return builder->finish(file);
}

}  // namespace

bool isGltf(const std::filesystem::path& path) {
  const std::string extension = lowerCaseExtension(path);
  return extension == ".glb" || extension == ".gltf";
}

Result<std::vector<std::string>> writeGltfBinary(OutputFile& file,
                                                 std::span<const NamedMesh> meshes,
                                                 const MeshWriteOptions& options) {
  return writeScene(Form::Binary, file, meshes, options);
}

Result<std::vector<std::string>> writeGltfText(OutputFile& file, std::span<const NamedMesh> meshes,
                                               const MeshWriteOptions& options) {
  return writeScene(Form::Text, file, meshes, options);
}

struct FlipbookWriter::State {
  struct Shown {
    std::uint64_t frame;
    int node;
  };

  GltfBuilder builder;
  OutputFile file;
  std::filesystem::path path;
  double framesPerSecond;
  std::uint64_t frameCount = 0;
  std::vector<Shown> shown = {};  // the frames that have a node

  double seconds(std::uint64_t frame) const { return static_cast<double>(frame) / framesPerSecond; }
  Result<void> animate();
  Result<int> addTimes(std::span<const std::uint64_t> frames);
};

/// The times of frames in seconds, strictly increasing as glTF demands.
Result<int> FlipbookWriter::State::addTimes(std::span<const std::uint64_t> frames) {
  std::vector<float> times;
  for (const std::uint64_t frame : frames) {
    const auto time = static_cast<float>(seconds(frame));
    if (!std::isfinite(time) || (!times.empty() && time <= times.back())) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("{} frames at {} a second are more than float32 times can distinguish",
                      frameCount, framesPerSecond));
    }
    times.push_back(time);
  }
  return builder.addFloats(times, 1, true, 0);
}

/// Keys at 0, where the scale changes, and at the end, or the last frame would have no duration.
Result<void> FlipbookWriter::State::animate() {
  tinygltf::Animation animation;
  animation.name = "flipbook";
  // One array of scales for each position of a frame: only, first, last, between.
  std::array<std::optional<int>, 4> scales;
  for (const auto& [frame, node] : shown) {
    const bool first = frame == 0;
    const bool last = frame + 1 == frameCount;
    std::vector<std::uint64_t> keys{0};
    std::vector<float> values(3, first ? 1.0F : 0.0F);
    const auto key = [&](std::uint64_t at, float scale) {
      keys.push_back(at);
      values.insert(values.end(), 3, scale);
    };
    if (!first) key(frame, 1);
    if (!last) key(frame + 1, 0);
    key(frameCount, last ? 1.0F : 0.0F);

    auto& output = scales[(first ? 1u : 0u) + (last ? 2u : 0u)];
    if (!output) {
      const auto added = builder.addFloats(values, 3, false, 0);
      if (!added) return pass(added.error());
      output = *added;
    }
    const auto input = addTimes(keys);
    if (!input) return pass(input.error());
    tinygltf::AnimationSampler sampler;
    sampler.input = *input;
    sampler.output = *output;
    sampler.interpolation = "STEP";
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation.samplers.size());
    channel.target_node = node;
    channel.target_path = "scale";
    animation.samplers.push_back(std::move(sampler));
    animation.channels.push_back(std::move(channel));
  }
  if (!animation.channels.empty()) builder.model().animations.push_back(std::move(animation));
  return {};
}

FlipbookWriter::FlipbookWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
FlipbookWriter::FlipbookWriter(FlipbookWriter&&) noexcept = default;
FlipbookWriter& FlipbookWriter::operator=(FlipbookWriter&&) noexcept = default;
FlipbookWriter::~FlipbookWriter() = default;

Result<FlipbookWriter> FlipbookWriter::create(const std::filesystem::path& path,
                                              double framesPerSecond,
                                              const MeshWriteOptions& options) {
  if (!(framesPerSecond > 0) || !std::isfinite(framesPerSecond)) {
    return invalid(fmt::format("{} frames a second, expected more than 0", framesPerSecond),
                   path.string());
  }
  if (!isGltf(path)) {
    return fail(ErrorCode::Unsupported,
                "unsupported output extension; a flipbook is written as .glb or .gltf",
                path.string());
  }
  const Form form = lowerCaseExtension(path) == ".glb" ? Form::Binary : Form::Text;
  auto builder = GltfBuilder::create(form, options, {});
  if (!builder) return inFile(path, builder.error());
  auto file = OutputFile::create(path);
  if (!file) return pass(file.error());
  return FlipbookWriter(std::unique_ptr<State>(
      new State{std::move(*builder), std::move(*file), path, framesPerSecond}));
}

Result<void> FlipbookWriter::add(double meshTime, std::span<const NamedMesh> meshes) {
  const std::uint64_t frame = state_->frameCount;
  if (!std::isfinite(meshTime)) {
    return invalid(fmt::format("frame {} is at time {}, expected a finite one", frame, meshTime),
                   state_->path.string());
  }
  std::vector<std::pair<int, const NamedMesh*>> visible;
  for (const NamedMesh& named : meshes) {
    const auto mesh = state_->builder.addMesh(named);
    if (!mesh) return inFile(state_->path, mesh.error());
    if (*mesh >= 0) visible.emplace_back(*mesh, &named);
  }
  ++state_->frameCount;
  if (visible.empty()) return {};

  tinygltf::Node node;
  node.name = fmt::format("frame {}", frame);
  if (frame > 0) node.scale = {0, 0, 0};
  node.extras = tinygltf::Value(tinygltf::Value::Object{{"time", tinygltf::Value(meshTime)}});
  if (meshes.size() == 1) node.mesh = visible.front().first;
  const int index = state_->builder.addNode(std::move(node));
  state_->shown.push_back({frame, index});
  if (meshes.size() == 1) return {};
  for (const auto& [mesh, named] : visible) {
    tinygltf::Node body;
    body.name = named->name;
    body.mesh = mesh;
    state_->builder.addNode(std::move(body), index);
  }
  return {};
}

Result<std::vector<std::string>> FlipbookWriter::finish() {
  if (state_->frameCount == 0) return invalid("a flipbook without frames", state_->path.string());
  if (auto done = state_->animate(); !done) return inFile(state_->path, done.error());
  auto lost = state_->builder.finish(state_->file);
  if (!lost) return inFile(state_->path, lost.error());
  if (auto done = state_->file.commit(); !done) return pass(done.error());
  return lost;
}

}  // namespace t4d::formats
