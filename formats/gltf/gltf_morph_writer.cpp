#include "formats/gltf/gltf_morph_writer.h"

#include <limits>

#include <fmt/format.h>

#include "formats/gltf/gltf_builder.h"
#include "formats/gltf/gltf_channels.h"
#include "formats/output_file.h"
#include "formats/triangle/written_mesh.h"

namespace t4d::formats {

struct MorphWriter::State {
  struct Body {
    int mesh = -1;
    int node = -1;
    std::vector<float> seconds = {};  // of its shapes
    std::vector<std::pair<double, bool>> shown = {};
  };

  std::filesystem::path path;
  OutputFile file;
  GltfBuilder builder;
  std::vector<Body> bodies = {};
  std::size_t vertexCount = 0;  // of the last body
  std::vector<model::Triangle> triangles = {};
  GltfBuilder::Layout layout = {};

  Result<void> animate(double end);
  Result<void> animate(const Body& body, double end, GltfChannels& channels);
};

/// Weights: a row for each key, 1 for its shape. The first shape has no target.
Result<void> MorphWriter::State::animate(const Body& body, double end, GltfChannels& channels) {
  const std::size_t targets = body.seconds.size() - 1;
  if (targets == 0) return {};
  std::vector<float> seconds = body.seconds;
  std::vector<std::uint32_t> ones;
  // Where the ones are is a 32-bit number, and so is what players count in.
  if (targets >= std::numeric_limits<std::uint32_t>::max() / (targets + 2)) {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("{} morph targets are more than their weights can be counted for", targets));
  }
  for (std::size_t i = 0; i < targets; ++i) {
    ones.push_back(static_cast<std::uint32_t>((i + 1) * targets + i));
  }
  // All channels have the same length.
  if (static_cast<float>(end) > seconds.back()) {
    seconds.push_back(static_cast<float>(end));
    ones.push_back(static_cast<std::uint32_t>(seconds.size() * targets - 1));
  }
  const auto weights = builder.addOnes(seconds.size() * targets, ones);
  if (!weights) return weights.error();
  return channels.add(body.node, "weights", "LINEAR", seconds, *weights);
}

Result<void> MorphWriter::State::animate(double end) {
  GltfChannels channels(builder, "motion");
  for (const Body& body : bodies) {
    if (body.mesh < 0) continue;
    if (auto done = animate(body, end, channels); !done) return done;
    if (auto done = channels.addShown(body.node, body.shown, end); !done) return done;
  }
  channels.finish();
  return {};
}

MorphWriter::MorphWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
MorphWriter::MorphWriter(MorphWriter&&) noexcept = default;
MorphWriter& MorphWriter::operator=(MorphWriter&&) noexcept = default;
MorphWriter::~MorphWriter() = default;

Result<MorphWriter> MorphWriter::create(const std::filesystem::path& path,
                                        const MeshWriteOptions& options) {
  auto builder = animationBuilder(path, options);
  if (!builder) return builder.error();
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  return MorphWriter(
      std::unique_ptr<State>(new State{path, std::move(*file), std::move(*builder)}));
}

Result<void> MorphWriter::addBody(const NamedMesh& first, double seconds,
                                  std::span<const std::pair<double, bool>> shown) {
  State& state = *state_;
  const auto mesh = state.builder.addMesh(first, state.builder.center(), state.layout);
  if (!mesh) return inFile(state.path, mesh.error());
  State::Body body;
  body.mesh = *mesh;
  body.seconds.push_back(static_cast<float>(seconds));
  body.shown.assign(shown.begin(), shown.end());
  if (*mesh >= 0) {
    tinygltf::Node node;
    node.name = first.name;
    node.mesh = *mesh;
    if (!shown.empty() && !shown.front().second) node.scale = {0, 0, 0};
    body.node = state.builder.addNode(std::move(node));
  }
  state.vertexCount = first.mesh.vertices.size();
  state.triangles = first.mesh.triangles;
  state.bodies.push_back(std::move(body));
  return {};
}

Result<void> MorphWriter::addShape(const NamedMesh& shape, double seconds) {
  State& state = *state_;
  if (state.bodies.empty()) return invalid("a shape of no body", state.path.string());
  State::Body& body = state.bodies.back();
  if (shape.mesh.vertices.size() != state.vertexCount || shape.mesh.triangles != state.triangles) {
    return invalid(fmt::format("mesh '{}': a shape with other triangles, or another number of "
                               "vertices, than the first",
                               shape.name),
                   state.path.string());
  }
  const auto time = static_cast<float>(seconds);
  if (body.mesh < 0 || time <= body.seconds.back()) return {};
  auto added = state.builder.addTarget(body.mesh, state.layout, shape, state.builder.center());
  if (!added) return inFile(state.path, added.error());
  body.seconds.push_back(time);
  return {};
}

Result<std::vector<std::string>> MorphWriter::finish(double seconds) {
  State& state = *state_;
  if (auto done = state.animate(seconds); !done) return inFile(state.path, done.error());
  auto lost = state.builder.finish(state.file);
  if (!lost) return inFile(state.path, lost.error());
  if (auto done = state.file.commit(); !done) return done.error();
  return lost;
}

}  // namespace t4d::formats
