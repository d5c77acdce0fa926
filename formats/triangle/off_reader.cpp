#include "formats/triangle/off_reader.h"

#include <vector>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "formats/triangle/mesh_builder.h"

namespace t4d::formats {
namespace {

// The shortest possible lines, with their ends: "0 0 0" and "3 0 0 0".
constexpr std::size_t kVertexBytes = 6;
constexpr std::size_t kFaceBytes = 8;

class Reader {
 public:
  explicit Reader(const InputFile& file)
      : scanner_(file, {.comment = '#'}),
        builder_(file.path.string(), [&](auto line) { return file.atLine(line); }) {}

  Result<LoadedMesh> read() {
    if (auto done = readHeader(); !done) return done.error();
    for (std::int64_t i = 0; i < vertexCount_; ++i) {
      if (auto done = readVertex(i); !done) return done.error();
    }
    for (std::int64_t i = 0; i < faceCount_; ++i) {
      if (auto done = readFace(i); !done) return done.error();
    }
    if (scanner_.nextLine()) {
      return scanner_.unexpectedWord(scanner_.word(),
                                     fmt::format("the end of the file after {} faces", faceCount_));
    }
    return std::move(builder_).finish();
  }

 private:
  Result<void> readHeader() {
    scanner_.nextLine();
    const auto keyword = scanner_.word();
    if (auto known = judgeKeyword(keyword); !known) return known;
    if (!scanner_.hasWord()) scanner_.nextLine();
    const auto first = scanner_.word();
    if (first == "BINARY") {
      return fail(ErrorCode::Unsupported, "is binary OFF, which is not supported",
                  scanner_.where());
    }
    // The count of edges is not needed, and some files omit it.
    if (!scanner_.parse(first, vertexCount_, "the number of vertices") ||
        !scanner_.integer(faceCount_, "the number of faces")) {
      return scanner_.error();
    }
    for (const auto& [count, bytes, what] : {std::tuple{vertexCount_, kVertexBytes, "vertices"},
                                             std::tuple{faceCount_, kFaceBytes, "faces"}}) {
      if (count < 0 || static_cast<std::uint64_t>(count) > scanner_.bytesLeft() / bytes + 1) {
        return scanner_.invalidHere(
            fmt::format("declares {} {}, which the {} bytes that follow cannot hold", count, what,
                        scanner_.bytesLeft()));
      }
    }
    builder_.reserve(static_cast<std::size_t>(vertexCount_), static_cast<std::size_t>(faceCount_));
    return {};
  }

  Result<void> judgeKeyword(std::string_view keyword) {
    auto prefix = keyword;
    if (!prefix.ends_with("OFF")) return scanner_.unexpectedWord(keyword, "'OFF'");
    prefix.remove_suffix(3);
    for (const std::string_view known : {"ST", "C", "N"}) {
      if (prefix.starts_with(known)) prefix.remove_prefix(known.size());
    }
    if (prefix.empty()) return {};
    if (prefix == "4" || prefix == "n" || prefix == "4n") {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("is {}, not a mesh in three dimensions; expected 'OFF'", inQuotes(keyword)),
          scanner_.where());
    }
    return scanner_.unexpectedWord(keyword, "'OFF'");
  }

  Result<void> nextLine(std::int64_t index, std::int64_t count, const char* what) {
    if (scanner_.nextLine()) return {};
    return scanner_.invalidHere(fmt::format("the file ends after {} of {} {}", index, count, what));
  }

  /// The position comes first; normals, colours and texture coordinates may follow.
  Result<void> readVertex(std::int64_t index) {
    if (auto found = nextLine(index, vertexCount_, "vertices"); !found) return found;
    model::Point3 point;
    for (double& coordinate : point) {
      if (!scanner_.number(coordinate, "a coordinate")) return scanner_.error();
    }
    return builder_.addPoint(point, scanner_.line());
  }

  /// The number of corners, the corners; a colour may follow.
  Result<void> readFace(std::int64_t index) {
    if (auto found = nextLine(index, faceCount_, "faces"); !found) return found;
    std::int64_t count = 0;
    if (!scanner_.integer(count, "the number of corners")) return scanner_.error();
    corners_.clear();
    for (std::int64_t i = 0; i < count; ++i) {
      std::int64_t corner = 0;
      if (!scanner_.integer(corner, "the number of a vertex")) return scanner_.error();
      if (corner < 0) {
        return scanner_.invalidHere(
            fmt::format("a face refers to vertex {}; expected 0 or more", corner));
      }
      corners_.push_back(static_cast<std::uint64_t>(corner));
    }
    return builder_.addPolygon(corners_, scanner_.line());
  }

  TextScanner scanner_;
  MeshBuilder builder_;
  std::int64_t vertexCount_ = 0;
  std::int64_t faceCount_ = 0;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

Result<LoadedMesh> readOff(const InputFile& file, Keep /*keep*/) { return Reader(file).read(); }

}  // namespace t4d::formats
