#include "t4d/formats/obj_reader.h"

#include <vector>

#include <fmt/format.h>

#include "t4d/formats/mesh_builder.h"
#include "t4d/formats/text_scanner.h"

namespace t4d::formats {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const InputFile& file)
      : scanner_(file, {.comment = '#', .continuation = true}),
        builder_(
            file.path.string(), [&](auto line) { return file.atLine(line); }, 1) {}

  Result<LoadedMesh> read() {
    while (scanner_.nextLine()) {
      const auto statement = scanner_.word();
      Result<void> done;
      if (statement == "v") done = readVertex();
      if (statement == "f") done = readFace();
      if (!done) return pass(done.error());
    }
    return std::move(builder_).finish();
  }

 private:
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

  TextScanner scanner_;
  MeshBuilder builder_;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

Result<LoadedMesh> readObj(const InputFile& file) { return ObjReader(file).read(); }

}  // namespace t4d::formats
