#include "t4d/formats/obj_reader.h"

#include <algorithm>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/mesh_bodies.h"
#include "t4d/formats/mesh_builder.h"
#include "t4d/formats/text_scanner.h"

namespace t4d::formats {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const InputFile& file, std::optional<BodiesBy> by = {})
      : by_(by == BodiesBy::Object  ? "o"
            : by == BodiesBy::Group ? "g"
                                    : ""),
        names_{file.path.stem().string()},
        scanner_(file, {.comment = '#', .continuation = true}),
        builder_(
            file.path.string(), [&](auto line) { return file.atLine(line); }, 1) {}

  Result<LoadedMesh> read() {
    while (scanner_.nextLine()) {
      const auto statement = scanner_.word();
      Result<void> done;
      if (statement == "v") done = readVertex();
      if (statement == "f") done = readFace();
      if (statement == by_ && !by_.empty()) beginBody(scanner_.rest());
      if (!done) return pass(done.error());
    }
    return std::move(builder_).finish();
  }

  Result<LoadedBodies> readBodies() {
    std::vector<std::uint32_t> bodyOf;
    builder_.keepPartsIn(bodyOf);
    auto loaded = read();
    if (!loaded) return pass(loaded.error());
    LoadedBodies result{{}, std::move(loaded->notices)};
    std::vector<model::TriangleMesh> meshes(names_.size());
    for (std::size_t i = 0; i < bodyOf.size(); ++i) {
      meshes[bodyOf[i]].triangles.push_back(loaded->mesh.triangles[i]);
    }
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      if (meshes[i].triangles.empty()) continue;
      takeVertices(meshes[i], loaded->mesh.vertices);
      result.bodies.push_back({names_[i], std::move(meshes[i])});
    }
    return result;
  }

 private:
  /// Faces belong to the body of this name from now on.
  void beginBody(std::string_view name) {
    const std::string text = name.empty() ? "default" : std::string(name);
    const auto found = std::ranges::find(names_.begin() + 1, names_.end(), text);
    builder_.setPart(static_cast<std::uint32_t>(found - names_.begin()));
    if (found == names_.end()) names_.push_back(text);
  }

  /// Gives a mesh those of these vertices that its triangles use, in their order.
  static void takeVertices(model::TriangleMesh& mesh, const std::vector<model::Point3>& all) {
    std::vector<std::uint32_t> used;
    for (const auto& triangle : mesh.triangles) {
      used.insert(used.end(), triangle.begin(), triangle.end());
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::uint32_t vertex : used) mesh.vertices.push_back(all[vertex]);
    for (auto& triangle : mesh.triangles) {
      for (std::uint32_t& corner : triangle) {
        corner = static_cast<std::uint32_t>(std::ranges::lower_bound(used, corner) - used.begin());
      }
    }
  }

  /// Three coordinates; a weight or a colour may follow.
  Result<void> readVertex() {
    const auto line = scanner_.line();
    model::Point3 point;
    for (double& coordinate : point) {
      if (!scanner_.number(coordinate, "a coordinate")) return pass(scanner_.error());
    }
    return builder_.addPoint(point, line);
  }

  Result<void> readFace() {
    const auto line = scanner_.line();
    corners_.clear();
    while (scanner_.hasWord()) {
      auto corner = readCorner(scanner_.word());
      if (!corner) return pass(corner.error());
      corners_.push_back(*corner);
    }
    return builder_.addPolygon(corners_, line);
  }

  /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; v counts from 1, or backwards from the latest vertex.
  Result<std::uint64_t> readCorner(std::string_view word) {
    constexpr const char* kExpected = "a corner V, V/VT, V//VN or V/VT/VN";
    const std::size_t slash = std::min(word.find('/'), word.size());
    std::int64_t index = 0;
    if (!scanner_.parse(word.substr(0, slash), index, kExpected) ||
        word.substr(slash).find_first_not_of("/+-0123456789") != word.npos) {
      return scanner_.unexpectedWord(word, kExpected);
    }
    const auto count = static_cast<std::int64_t>(builder_.pointCount());
    if (index == 0) return scanner_.invalidHere("a face refers to vertex 0, but OBJ counts from 1");
    if (index < -count) {
      return scanner_.invalidHere(
          fmt::format("a face refers to vertex {}, but only {} come before it", index, count));
    }
    return static_cast<std::uint64_t>(index > 0 ? index - 1 : count + index);
  }

  std::string_view by_;             // the statement that begins a body
  std::vector<std::string> names_;  // of bodies; first that of faces before all such statements
  TextScanner scanner_;
  MeshBuilder builder_;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

Result<LoadedMesh> readObj(const InputFile& file) { return ObjReader(file).read(); }

Result<LoadedBodies> readMeshBodies(const std::filesystem::path& path, BodiesBy by) {
  if (lowerCaseExtension(path) != ".obj") {
    return fail(ErrorCode::Unsupported, "is no .obj; only these are divided into bodies",
                path.string());
  }
  const auto file = readInputFile(path);
  if (!file) return pass(file.error());
  try {
    return ObjReader(*file, by).readBodies();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "the mesh does not fit in memory", path.string());
  }
}

}  // namespace t4d::formats
