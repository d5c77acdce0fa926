#include "formats/triangle/obj_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/text/text_scanner.h"
#include "formats/triangle/mesh_bodies.h"
#include "formats/triangle/mesh_builder.h"
#include "t4d/mesh.h"

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

  Result<LoadedMesh> read(Keep keep) {
    keepsAttributes_ = keep == Keep::Attributes;
    while (scanner_.nextLine()) {
      const auto statement = scanner_.word();
      Result<void> done;
      if (statement == "v") done = readVertex();
      if (statement == "f") done = readFace();
      if (statement == "vt" && keepsAttributes_) readUv();
      if (statement == "vn") hasNormals_ = true;
      if (statement == by_ && !by_.empty()) beginBody(scanner_.rest());
      if (statement == "usemtl") beginMaterial(scanner_.rest());
      if (statement == "mtllib") materialFiles_.emplace_back(scanner_.rest());
      if (!done) return done.error();
    }
    FileCorners corners;
    if (hasUvs() || hasColors_) builder_.keepCornersIn(corners);
    builder_.keepPartsIn(partOf_);
    auto loaded = std::move(builder_).finish();
    if (loaded && keepsAttributes_) addAttributes(corners, *loaded);
    return loaded;
  }

  Result<LoadedBodies> readBodies(Keep keep) {
    auto loaded = read(keep);
    if (!loaded) return loaded.error();
    LoadedBodies result{{}, std::move(loaded->notices), std::move(loaded->materials)};
    std::vector<std::vector<std::uint32_t>> trianglesOf(names_.size());
    for (std::uint32_t i = 0; i < partOf_.size(); ++i) {
      trianglesOf[parts_[partOf_[i]].body].push_back(i);
    }
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (trianglesOf[i].empty()) continue;
      result.bodies.push_back({names_[i], bodyMesh(trianglesOf[i], *loaded)});
    }
    return result;
  }

 private:
  /// The part that faces belong to.
  struct Part {
    std::uint32_t body = 0;      // of names_
    std::uint32_t material = 0;  // of materials_
    auto operator<=>(const Part&) const = default;
  };

  /// The number of a name, which joins the others unless it is there; `first` names are not looked
  /// at.
  static std::uint32_t numberOf(const std::string& name, std::vector<std::string>& names,
                                std::ptrdiff_t first) {
    const auto found = std::ranges::find(names.begin() + first, names.end(), name);
    const auto number = static_cast<std::uint32_t>(found - names.begin());
    if (found == names.end()) names.push_back(name);
    return number;
  }

  /// Assigns the faces that follow to the body of this name.
  void beginBody(std::string_view name) {
    current_.body = numberOf(name.empty() ? "default" : std::string(name), names_, 1);
    beginPart();
  }

  /// Assigns the faces that follow to the material of this name.
  void beginMaterial(std::string_view name) {
    hasMaterials_ = true;
    current_.material = numberOf(std::string(name), materials_, 0);
    beginPart();
  }

  void beginPart() {
    const auto [found, added] =
        numberOfPart_.emplace(current_, static_cast<std::uint32_t>(parts_.size()));
    if (added) parts_.push_back(current_);
    builder_.setPart(found->second);
  }

  /// These triangles, with the vertices that they use, in their order, and their attributes.
  static model::TriangleMesh bodyMesh(const std::vector<std::uint32_t>& triangles,
                                      const LoadedMesh& all) {
    model::TriangleMesh mesh;
    std::vector<std::uint32_t> used;
    for (const std::uint32_t i : triangles) {
      const model::Triangle& triangle = mesh.triangles.emplace_back(all.mesh.triangles[i]);
      used.insert(used.end(), triangle.begin(), triangle.end());
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::uint32_t vertex : used) mesh.vertices.push_back(all.mesh.vertices[vertex]);
    for (auto& triangle : mesh.triangles) {
      for (std::uint32_t& corner : triangle) {
        corner = static_cast<std::uint32_t>(std::ranges::lower_bound(used, corner) - used.begin());
      }
    }
    for (const model::Attribute& of : all.mesh.attributes) {
      model::Attribute rows{of.name, of.domain, of.type, of.components, {}};
      for (const std::uint32_t i : of.domain == model::Domain::Vertex ? used : triangles) {
        rows.values.insert(rows.values.end(), of.row(i), of.row(i) + of.rowBytes());
      }
      mesh.attributes.push_back(std::move(rows));
    }
    return mesh;
  }

  bool hasUvs() const { return !uvs_.empty() && !uvOf_.empty(); }

  void addAttributes(const FileCorners& corners, LoadedMesh& loaded) {
    if (hasColors_) {
      colors_.resize(3 * pointCount_, 255);
      auto rows = model::makeAttribute("color", model::Domain::Vertex, colors_);
      rows.components = 3;
      if (colorFault_.empty()) {
        loaded.mesh.attributes.push_back(
            cornerAttribute(rows, corners.points, corners, loaded.mesh));
        if (coloredPoints_ < pointCount_) {
          loaded.notices.push_back(fmt::format("{} of {} vertices have no colour: white there",
                                               pointCount_ - coloredPoints_, pointCount_));
        }
      } else {
        loaded.notices.push_back("colours of vertices left out: " + colorFault_);
      }
    }
    if (hasUvs()) addUvs(corners, loaded);
    if (hasMaterials_) {
      std::vector<std::uint32_t> numbers;
      for (const std::uint32_t part : partOf_) numbers.push_back(parts_[part].material);
      loaded.mesh.attributes.push_back(
          model::makeAttribute("material", model::Domain::Cell, numbers));
      loaded.materials = materials_;
    }
    if (hasNormals_) loaded.notices.emplace_back("normals are not kept");
    for (const std::string& file : materialFiles_) {
      loaded.notices.push_back(
          fmt::format("materials and textures of {} are not kept, only names", inQuotes(file)));
    }
  }

  void addUvs(const FileCorners& corners, LoadedMesh& loaded) {
    uvOf_.resize(corners.points.size(), model::kNoIndex);
    const auto count = static_cast<std::uint32_t>(uvs_.size() / 2);
    std::size_t missing = 0;
    for (std::uint32_t& row : uvOf_) {
      if (row != model::kNoIndex && row >= count && uvFault_.empty()) {
        uvFault_ = fmt::format("a face refers to texture coordinate {}, but there are {}",
                               std::uint64_t{row} + 1, count);
      }
      missing += row == model::kNoIndex;
      if (row == model::kNoIndex) row = count;  // behind the last
    }
    if (!uvFault_.empty()) {
      loaded.notices.push_back("texture coordinates left out: " + uvFault_);
      return;
    }
    uvs_.resize(uvs_.size() + 2, 0);
    auto rows = model::makeAttribute("uv", model::Domain::Vertex, uvs_);
    rows.components = 2;
    loaded.mesh.attributes.push_back(cornerAttribute(rows, uvOf_, corners, loaded.mesh));
    if (missing > 0) {
      loaded.notices.push_back(
          fmt::format("{} of {} corners of faces have no texture coordinates: 0 0 there", missing,
                      uvOf_.size()));
    }
  }

  /// Three coordinates; a weight or a colour may follow.
  Result<void> readVertex() {
    const auto line = scanner_.line();
    model::Point3 point;
    for (double& coordinate : point) {
      if (!scanner_.number(coordinate, "a coordinate")) return scanner_.error();
    }
    if (auto added = builder_.addPoint(point, line); !added) return added;
    ++pointCount_;
    if (keepsAttributes_ && scanner_.hasWord()) readColor();
    return {};
  }

  /// Three numbers after the coordinates are a colour, one is a weight. Neither is checked where it
  /// says nothing about the shape.
  void readColor() {
    std::array<double, 3> color{};
    std::size_t count = 0;
    for (; scanner_.hasWord(); ++count) {
      const std::string_view word = scanner_.word();
      if (count >= 3 || !scanner_.parse(word, color[count], "")) return;
    }
    if (count != 3) return;
    hasColors_ = true;
    ++coloredPoints_;
    colors_.resize(3 * (pointCount_ - 1), 255);
    for (const double part : color) {
      const bool isGood = part >= 0 && part <= 1;
      if (!isGood && colorFault_.empty()) {
        colorFault_ =
            fmt::format("line {} has {}, expected numbers from 0 to 1", scanner_.line(), part);
      }
      colors_.push_back(static_cast<std::uint8_t>(isGood ? std::lround(255 * part) : 0));
    }
  }

  /// `vt u`, `vt u v` or `vt u v w`.
  void readUv() {
    std::array<double, 2> uv{};
    for (std::size_t i = 0; i < 2 && (i == 0 || scanner_.hasWord()); ++i) {
      const std::string_view word = scanner_.word();
      if (!scanner_.parse(word, uv[i], "") && uvFault_.empty()) {
        uvFault_ = fmt::format("line {} has {}, expected numbers", scanner_.line(), inQuotes(word));
      }
    }
    for (const double number : uv) uvs_.push_back(static_cast<float>(number));
  }

  Result<void> readFace() {
    const auto line = scanner_.line();
    corners_.clear();
    while (scanner_.hasWord()) {
      auto corner = readCorner(scanner_.word());
      if (!corner) return corner.error();
      corners_.push_back(*corner);
    }
    cornerCount_ += corners_.size();
    return builder_.addPolygon(corners_, line);
  }

  /// Notes the texture coordinates of a corner: `word` is what follows its first slash.
  void readCornerUv(std::string_view word) {
    word = word.substr(0, std::min(word.find('/'), word.size()));
    if (word.empty()) return;
    const auto count = static_cast<std::int64_t>(uvs_.size() / 2);
    std::int64_t index = 0;
    const bool isNumber = scanner_.parse(word, index, "");
    if (isNumber && index < 0) index += count + 1;
    if ((!isNumber || index <= 0 || index >= std::int64_t{model::kNoIndex}) && uvFault_.empty()) {
      uvFault_ = fmt::format("line {} refers to {}, but {} come before it", scanner_.line(),
                             inQuotes(word), count);
    }
    if (!uvFault_.empty()) index = 1;
    uvOf_.resize(cornerCount_ + corners_.size(), model::kNoIndex);
    uvOf_.push_back(static_cast<std::uint32_t>(index - 1));
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
    if (keepsAttributes_ && slash < word.size()) readCornerUv(word.substr(slash + 1));
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
  std::vector<std::string> materials_ = {""};
  std::vector<Part> parts_ = {Part{}};
  std::map<Part, std::uint32_t> numberOfPart_ = {{Part{}, 0}};
  Part current_;
  std::vector<std::uint32_t> partOf_;  // of the triangles
  bool keepsAttributes_ = false;
  bool hasMaterials_ = false;
  bool hasNormals_ = false;
  std::vector<std::string> materialFiles_;
  std::size_t pointCount_ = 0;
  bool hasColors_ = false;
  std::size_t coloredPoints_ = 0;
  std::vector<std::uint8_t> colors_;  // three for each point up to the last that has them
  std::string colorFault_;            // why the colours are left out
  std::vector<float> uvs_;
  std::vector<std::uint32_t>
      uvOf_;                     // of each corner up to the last that has one; or model::kNoIndex
  std::size_t cornerCount_ = 0;  // of all faces
  std::string uvFault_;
  TextScanner scanner_;
  MeshBuilder builder_;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

Result<LoadedMesh> readObj(const InputFile& file, Keep keep) { return ObjReader(file).read(keep); }

Result<LoadedBodies> readMeshBodies(const std::filesystem::path& path, BodiesBy by, Keep keep) {
  if (lowerCaseExtension(path) != ".obj") {
    return fail(ErrorCode::Unsupported, "is not an .obj; only these are divided into bodies",
                path.string());
  }
  const auto file = readInputFile(path);
  if (!file) return file.error();
  try {
    return ObjReader(*file, by).readBodies(keep);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "the mesh does not fit in memory", path.string());
  }
}

}  // namespace t4d::formats
