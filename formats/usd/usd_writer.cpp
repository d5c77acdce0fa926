#include "formats/usd/usd_writer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/triangle/written_mesh.h"
#include "formats/usd/usd_stage.h"
#include "platform/replaceable.h"

namespace t4d::formats {
namespace {

using UsdForm = UsdStage::Form;

UsdForm usdFormOf(const std::filesystem::path& path) {
  return lowerCaseExtension(path) == ".usdz" ? UsdForm::Package : UsdForm::Text;
}

/// One frame of a series: of every body, whether it is there.
Result<std::vector<std::string>> writeClip(UsdStage& stage, OutputFile& file,
                                           std::span<const NamedMesh> meshes,
                                           const MeshWriteOptions& options) {
  const double code = *options.usd.timeCode;
  for (const std::string& name : options.usd.bodies) {
    const std::size_t body = stage.addBody(name);
    const auto found = std::ranges::find(meshes, name, &NamedMesh::name);
    const bool visible = found != meshes.end() && !found->mesh.triangles.empty();
    if (auto done = stage.show(body, code, visible); !done) return done.error();
    if (!visible) continue;
    auto done = stage.sample(body, code, *found, options.center);
    if (!done) return done.error();
  }
  if (options.time) {
    if (auto done = stage.meshTime(code, *options.time); !done) return done.error();
  }
  return stage.finish(file, {code, code});
}

Result<std::vector<std::string>> writeUsdMeshes(UsdForm form, OutputFile& file,
                                                std::span<const NamedMesh> meshes,
                                                const MeshWriteOptions& options) {
  auto stage = UsdStage::create(form, options.usd.timeCodesPerSecond, options);
  if (!stage) return stage.error();
  if (options.usd.timeCode) return writeClip(*stage, file, meshes, options);
  for (const NamedMesh& named : meshes) {
    auto done = stage->sample(stage->addBody(named.name), 0, named, options.center);
    if (!done) return done.error();
  }
  return stage->finish(file, {0, 0});
}

}  // namespace

bool isUsd(const std::filesystem::path& path) {
  const std::string extension = lowerCaseExtension(path);
  return extension == ".usda" || extension == ".usdz";
}

Result<std::vector<std::string>> writeUsdText(OutputFile& file, std::span<const NamedMesh> meshes,
                                              const MeshWriteOptions& options) {
  return writeUsdMeshes(UsdForm::Text, file, meshes, options);
}

Result<std::vector<std::string>> writeUsdPackage(OutputFile& file,
                                                 std::span<const NamedMesh> meshes,
                                                 const MeshWriteOptions& options) {
  return writeUsdMeshes(UsdForm::Package, file, meshes, options);
}

struct UsdWriter::State {
  std::filesystem::path path;
  OutputFile file;
  UsdStage stage;
  std::uint64_t samples = 0;
  std::uint64_t maxBytes = 0;
  std::uint64_t frames = 0;
  std::uint64_t firstBytes = 0;  // of the first frame
  std::map<std::string, std::size_t> bodies = {};
  std::size_t last = 0;  // body that has shapes
  std::uint64_t shapes = 0;
  std::vector<std::filesystem::path> files = {};

  Result<std::size_t> bodyOf(const std::string& name);
  Result<void> checkSize(std::uint64_t done, std::uint64_t all);
  Result<void> begin(const std::string& name, std::span<const std::pair<double, bool>> shown);
};

UsdWriter::UsdWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
UsdWriter::UsdWriter(UsdWriter&&) noexcept = default;
UsdWriter& UsdWriter::operator=(UsdWriter&&) noexcept = default;
UsdWriter::~UsdWriter() = default;

Result<UsdWriter> UsdWriter::create(const std::filesystem::path& path, double timeCodesPerSecond,
                                    std::uint64_t samples, const MeshWriteOptions& options) {
  if (!isUsd(path)) {
    return fail(ErrorCode::Unsupported,
                "unsupported output extension; USD is written as .usda or .usdz", path.string());
  }
  auto stage = UsdStage::create(usdFormOf(path), timeCodesPerSecond, options);
  if (!stage) return inFile(path, stage.error());
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  return UsdWriter(std::unique_ptr<State>(
      new State{path, std::move(*file), std::move(*stage), samples, options.usd.maxBytes}));
}

/// The number of a body, which was invisible until now if it is new.
Result<std::size_t> UsdWriter::State::bodyOf(const std::string& name) {
  const auto found = bodies.find(name);
  if (found != bodies.end()) return found->second;
  const std::size_t body = stage.addBody(name);
  bodies.emplace(name, body);
  if (frames > 0) {
    if (auto done = stage.show(body, 0, false); !done) return done.error();
  }
  return body;
}

/// Fails if the text will be too large, after `done` of `all` samples. The first has what others
/// need not repeat.
Result<void> UsdWriter::State::checkSize(std::uint64_t done, std::uint64_t all) {
  if (done == 1) firstBytes = stage.textBytes();
  if (done < 2) return {};
  const double each =
      static_cast<double>(stage.textBytes() - firstBytes) / static_cast<double>(done - 1);
  const double bytes = static_cast<double>(firstBytes) + each * static_cast<double>(all - 1);
  if (bytes <= static_cast<double>(maxBytes)) return {};
  return fail(ErrorCode::Unsupported,
              fmt::format("would have about {:.1f} GB of text, and readers of USD text take up to "
                          "{:.1f}; write fewer frames, or a file for each (a value clip set)",
                          bytes / 1e9, static_cast<double>(maxBytes) / 1e9),
              path.string());
}

Result<void> UsdWriter::add(double meshTime, std::span<const NamedMesh> meshes) {
  State& state = *state_;
  const auto code = static_cast<double>(state.frames);
  std::vector<std::size_t> seen;
  for (const NamedMesh& named : meshes) {
    if (named.mesh.triangles.empty()) continue;
    const auto body = state.bodyOf(named.name);
    if (!body) return inFile(state.path, body.error());
    seen.push_back(*body);
    auto done = state.stage.show(*body, code, true);
    if (!done) return inFile(state.path, done.error());
    done = state.stage.sample(*body, code, named, state.stage.center());
    if (!done) return inFile(state.path, done.error());
  }
  for (const auto& [name, body] : state.bodies) {
    if (std::ranges::find(seen, body) != seen.end()) continue;
    auto done = state.stage.show(body, code, false);
    if (!done) return inFile(state.path, done.error());
  }
  if (auto done = state.stage.meshTime(code, meshTime); !done) {
    return inFile(state.path, done.error());
  }
  ++state.frames;
  return state.checkSize(state.frames, state.samples);
}

Result<void> UsdWriter::State::begin(const std::string& name,
                                     std::span<const std::pair<double, bool>> shown) {
  last = stage.addBody(name);
  for (const auto& [time, visible] : shown) {
    if (auto done = stage.show(last, time, visible); !done) return done;
  }
  return {};
}

Result<void> UsdWriter::addBody(const NamedMesh& first, double timeCode,
                                std::span<const std::pair<double, bool>> shown) {
  State& state = *state_;
  if (auto done = state.begin(first.name, shown); !done) return inFile(state.path, done.error());
  auto done = state.stage.sample(state.last, timeCode, first, state.stage.center());
  if (!done) return inFile(state.path, done.error());
  state.shapes = 1;
  return state.checkSize(1, state.samples);
}

Result<void> UsdWriter::addShape(const NamedMesh& shape, double timeCode) {
  State& state = *state_;
  auto done = state.stage.sample(state.last, timeCode, shape, state.stage.center());
  if (!done) return inFile(state.path, done.error());
  return state.checkSize(++state.shapes, state.samples);
}

Result<void> UsdWriter::addRigid(const RigidBody& body) {
  State& state = *state_;
  const auto add = [&]() -> Result<void> {
    if (body.keys.empty()) return invalid(fmt::format("body '{}' has no keys", body.mesh.name));
    if (auto done = state.begin(body.mesh.name, body.shown); !done) return done;
    Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
    for (const RigidBody::Key& key : body.keys) {
      Eigen::Quaterniond rotation = key.rotation.normalized();
      // Of q and -q, which are the same rotation, take the one closer to the key before.
      if (rotation.dot(before) < 0) rotation.coeffs() = -rotation.coeffs();
      before = rotation;
      const model::Point3 place = key.translation - state.stage.center();
      if (!place.allFinite() || !rotation.coeffs().allFinite()) {
        return invalid(fmt::format("body '{}' moves beyond all numbers", body.mesh.name));
      }
      if (auto done = state.stage.pose(state.last, key.seconds, rotation, place); !done) {
        return done;
      }
    }
    return state.stage.sample(state.last, body.keys.front().seconds, body.mesh,
                              model::Point3::Zero());
  };
  if (auto done = add(); !done) return inFile(state.path, done.error());
  return {};
}

Result<std::vector<std::string>> UsdWriter::finish(double end) {
  State& state = *state_;
  auto lost = state.stage.finish(state.file, {0, std::max(0.0, end - 1)});
  if (!lost) return inFile(state.path, lost.error());
  if (auto done = state.file.commit(); !done) return done.error();
  state.files.push_back(state.path);
  return lost;
}

Result<std::vector<std::string>> UsdWriter::finish() {
  if (state_->frames == 0) return invalid("a flipbook without frames", state_->path.string());
  return finish(static_cast<double>(state_->frames));
}

const std::vector<std::filesystem::path>& UsdWriter::files() const { return state_->files; }

UsdClipSet::UsdClipSet(std::unique_ptr<UsdStage> stage) : stage_(std::move(stage)) {}
UsdClipSet::UsdClipSet(UsdClipSet&&) noexcept = default;
UsdClipSet& UsdClipSet::operator=(UsdClipSet&&) noexcept = default;
UsdClipSet::~UsdClipSet() = default;

Result<UsdClipSet> UsdClipSet::create(const MeshWriteOptions& options) {
  auto stage = UsdStage::create(UsdForm::Text, options.usd.timeCodesPerSecond, options);
  if (!stage) return stage.error();
  UsdClipSet made(std::make_unique<UsdStage>(std::move(*stage)));
  for (const std::string& name : options.usd.bodies) {
    made.bodies_.emplace(name, made.stage_->addBody(name));
  }
  return made;
}

Result<void> UsdClipSet::add(std::span<const NamedMesh> meshes) {
  for (const NamedMesh& named : meshes) {
    if (auto done = stage_->declare(bodies_.at(named.name), named); !done) return done;
  }
  return {};
}

Result<void> UsdClipSet::write(const std::filesystem::path& path,
                               std::span<const std::string> files) {
  const std::string name = path.filename().string();
  if (auto good = platform::checkReplaceable(path.parent_path(), {&name, 1}); !good) return good;
  const double end = static_cast<double>(files.size() - 1);
  std::string assets;
  std::string codes;  // pairs of one of the stage, and a clip or a time in it
  for (std::size_t i = 0; i < files.size(); ++i) {
    const char* comma = i == 0 ? "" : ", ";
    assets += fmt::format("{}@@@./{}@@@", comma, files[i]);
    codes += fmt::format("{0}({1}, {1})", comma, i);
  }
  const std::string clips = fmt::format(
      "clips = {{\n    dictionary default = {{\n        double2[] active = [{0}]\n"
      "        asset[] assetPaths = [{1}]\n        asset manifestAssetPath = @@@./{2}@@@\n"
      "        string primPath = \"/t4d\"\n        double2[] times = [{0}]\n    }}\n}}",
      codes, assets, name);
  auto file = OutputFile::create(path);
  if (!file) return file.error();
  auto written = stage_->finish(*file, {0, end}, clips);
  if (!written) return inFile(path, written.error());
  return file->commit();
}

}  // namespace t4d::formats
