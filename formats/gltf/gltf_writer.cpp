#include "formats/gltf/gltf_writer.h"

#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/gltf/gltf_animation.h"
#include "formats/gltf/gltf_builder.h"
#include "formats/triangle/written_mesh.h"
#include "platform/replaceable.h"

namespace t4d::formats {

namespace {

using Form = GltfBuilder::Form;

Result<std::vector<std::string>> writeScene(Form form, OutputFile& file,
                                            std::span<const NamedMesh> meshes,
                                            const MeshWriteOptions& options) {
  auto builder = GltfBuilder::create(form, options);
  if (!builder) return builder.error();
  for (const NamedMesh& named : meshes) {
    const auto mesh = builder->addMesh(named);
    if (!mesh) return mesh.error();
    if (*mesh < 0) continue;
    tinygltf::Node node;
    node.name = named.name;
    node.mesh = *mesh;
    builder->addNode(std::move(node));
  }
  return builder->finish(file);
}

}  // namespace

bool isGltf(const std::filesystem::path& path) { return isOneOf(animatedGltfFormats(), path); }

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
  std::optional<OutputFile> file;  // until there is a second one
  std::filesystem::path path;
  double framesPerSecond;
  MeshWriteOptions options;
  std::uint64_t firstFrame = 0;   // of the file
  std::uint64_t frameCount = 0;   // in the file
  std::uint64_t jsonBytes = 0;    // of the file's document, at most
  std::vector<Shown> shown = {};  // the frames that have a node
  std::vector<OutputFile> parts = {};
  std::vector<std::filesystem::path> files = {};
  std::vector<std::string> lost = {};

  double seconds(std::uint64_t frame) const { return static_cast<double>(frame) / framesPerSecond; }
  Result<void> animate();
  Result<int> addTimes(std::span<const std::uint64_t> frames);
  Result<int> addVisible(const std::vector<std::uint8_t>& values);
  Result<void> endFile(OutputFile& into);
  Result<void> endPart();
  std::uint64_t mostBytes(std::span<const NamedMesh> meshes) const;
  std::uint64_t mostJsonBytes(std::span<const NamedMesh> meshes) const;
};

namespace {

Result<GltfBuilder> builderOf(const std::filesystem::path& path, const MeshWriteOptions& options) {
  const Form form = lowerCaseExtension(path) == ".glb" ? Form::Binary : Form::Text;
  auto builder = GltfBuilder::create(form, options);
  if (builder && options.gltf.visibility) {
    builder->use("KHR_animation_pointer", true);
    builder->use("KHR_node_visibility", true);
  }
  return builder;
}

}  // namespace

/// The largest size of a frame in the buffer: what it shares with others is not known before.
std::uint64_t FlipbookWriter::State::mostBytes(std::span<const NamedMesh> meshes) const {
  std::uint64_t bytes = 64;  // times of its keys
  for (const NamedMesh& named : meshes) {
    const auto& mesh = named.mesh;
    const bool repeats =
        options.normals || (named.colors && named.colors->domain == model::Domain::Cell);
    const std::uint64_t vertices = repeats ? 3 * mesh.triangles.size() : mesh.vertices.size();
    const std::uint64_t attributes = options.attributes ? 16 * mesh.attributes.size() : 0;
    bytes += vertices * (12 + 12 + 8 + attributes) + 12 * mesh.triangles.size() + 64;
    if (options.attributes) bytes += 4 * options.materials.size();
  }
  return bytes;
}

/// The most bytes of a frame in the document.
std::uint64_t FlipbookWriter::State::mostJsonBytes(std::span<const NamedMesh> meshes) const {
  std::uint64_t bytes = 2048;  // its node, channel, sampler and times
  for (const NamedMesh& named : meshes) {
    // A byte of a name may become six, in a node and a mesh.
    bytes += 2048 + 12 * named.name.size();
    for (const auto& attribute : named.mesh.attributes) bytes += 512 + 6 * attribute.name.size();
    // A primitive for each material, each with the attributes.
    if (!options.attributes) continue;
    for (const std::string& material : options.materials) {
      bytes += 1024 + 6 * material.size() + 128 * named.mesh.attributes.size();
    }
  }
  return bytes;
}

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

/// One number for each key, or three to scale by.
Result<int> FlipbookWriter::State::addVisible(const std::vector<std::uint8_t>& values) {
  if (options.gltf.visibility) return builder.addTruths(values);
  std::vector<float> scales;
  for (const std::uint8_t value : values) scales.insert(scales.end(), 3, value);
  return builder.addFloats(scales, 3, false, 0);
}

/// Keys at 0, where it changes, and at the end, or the last frame would have no duration.
Result<void> FlipbookWriter::State::animate() {
  tinygltf::Animation animation;
  animation.name = "flipbook";
  // One array of values for each position of a frame: only, first, last, between.
  std::array<std::optional<int>, 4> arrays;
  for (const auto& [frame, node] : shown) {
    const bool first = frame == 0;
    const bool last = frame + 1 == frameCount;
    std::vector<std::uint64_t> keys{0};
    std::vector<std::uint8_t> values{static_cast<std::uint8_t>(first)};
    const auto key = [&](std::uint64_t at, bool visible) {
      keys.push_back(at);
      values.push_back(static_cast<std::uint8_t>(visible));
    };
    if (!first) key(frame, true);
    if (!last) key(frame + 1, false);
    key(frameCount, last);

    auto& output = arrays[(first ? 1u : 0u) + (last ? 2u : 0u)];
    if (!output) {
      const auto added = addVisible(values);
      if (!added) return added.error();
      output = *added;
    }
    const auto input = addTimes(keys);
    if (!input) return input.error();
    tinygltf::AnimationSampler sampler;
    sampler.input = *input;
    sampler.output = *output;
    sampler.interpolation = "STEP";
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation.samplers.size());
    channel.target_node = node;
    channel.target_path = "scale";
    if (options.gltf.visibility) builder.pointAt(channel, "KHR_node_visibility/visible");
    animation.samplers.push_back(std::move(sampler));
    animation.channels.push_back(std::move(channel));
  }
  if (!animation.channels.empty()) builder.model().animations.push_back(std::move(animation));
  return {};
}

Result<void> FlipbookWriter::State::endFile(OutputFile& into) {
  if (auto done = animate(); !done) return done;
  auto more = builder.finish(into);
  if (!more) return more.error();
  for (std::string& line : *more) addOnce(lost, std::move(line));
  return {};
}

/// Writes what there is to a file with a number, which gets its name in the end.
Result<void> FlipbookWriter::State::endPart() {
  file.reset();
  std::filesystem::path part = path;
  part.replace_filename(
      fmt::format("{}-{}{}", path.stem().string(), parts.size() + 1, path.extension().string()));
  const std::string name = part.filename().string();
  if (auto good = platform::checkReplaceable(part.parent_path(), {&name, 1}); !good) return good;
  auto created = OutputFile::create(part);
  if (!created) return created.error();
  parts.push_back(std::move(*created));
  files.push_back(part);
  if (auto done = endFile(parts.back()); !done) return done;
  auto next = builderOf(path, options);
  if (!next) return next.error();
  builder = std::move(*next);
  firstFrame += frameCount;
  frameCount = 0;
  jsonBytes = 0;
  shown.clear();
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
  auto builder = builderOf(path, options);
  if (!builder) return inFile(path, builder.error());
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  return FlipbookWriter(std::unique_ptr<State>(
      new State{std::move(*builder), std::move(*file), path, framesPerSecond, options}));
}

Result<void> FlipbookWriter::add(double meshTime, std::span<const NamedMesh> meshes) {
  State& state = *state_;
  if (!std::isfinite(meshTime)) {
    return invalid(fmt::format("frame {} is at time {}, expected a finite one",
                               state.firstFrame + state.frameCount, meshTime),
                   state.path.string());
  }
  // The document has a few members beside frames.
  const std::uint64_t json = state.mostJsonBytes(meshes);
  const std::uint64_t others = 4096 + 2 * state.options.placement.extras.size();
  if (state.frameCount > 0 &&
      state.builder.bufferBytes() + state.jsonBytes + json + others + state.mostBytes(meshes) >
          state.builder.maxBytes()) {
    if (auto done = state.endPart(); !done) return inFile(state.path, done.error());
  }
  state.jsonBytes += json;
  const std::uint64_t frame = state.frameCount;
  std::vector<std::pair<int, const NamedMesh*>> visible;
  for (const NamedMesh& named : meshes) {
    const auto mesh = state_->builder.addMesh(named);
    if (!mesh) return inFile(state_->path, mesh.error());
    if (*mesh >= 0) visible.emplace_back(*mesh, &named);
  }
  ++state_->frameCount;
  if (visible.empty()) return {};

  tinygltf::Node node;
  node.name = fmt::format("frame {}", state.firstFrame + frame);
  if (state.options.gltf.visibility) {
    node.extensions["KHR_node_visibility"] =
        tinygltf::Value(tinygltf::Value::Object{{"visible", tinygltf::Value(frame == 0)}});
  } else if (frame > 0) {
    node.scale = {0, 0, 0};
  }
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
  State& state = *state_;
  if (state.frameCount == 0) return invalid("a flipbook without frames", state.path.string());
  if (state.file) {
    if (auto done = state.endFile(*state.file); !done) return inFile(state.path, done.error());
    if (auto done = state.file->commit(); !done) return done.error();
    state.files.push_back(state.path);
    return state.lost;
  }
  if (auto done = state.endPart(); !done) return inFile(state.path, done.error());
  for (OutputFile& part : state.parts) {
    if (auto done = part.commit(); !done) return done.error();
  }
  return state.lost;
}

const std::vector<std::filesystem::path>& FlipbookWriter::files() const { return state_->files; }

}  // namespace t4d::formats
