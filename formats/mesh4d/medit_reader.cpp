#include "formats/mesh4d/medit_reader.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include "formats/mesh4d/medit_binary_reader.h"
#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/text/text_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

constexpr std::string_view kMeditMagic = "MeshVersionFormatted";

// The shortest numbers of a vertex and of a tetrahedron: "0 0 0 0 0".
constexpr std::size_t kShortestMeditElement = 9;

class MeditReader {
 public:
  explicit MeditReader(const InputFile& file)
      : file_(file),
        text_(file, {.comment = '#'}),
        mesh_(
            file.path.string(), [&file](auto line) { return file.atLine(line); }, 1) {}

  Result<LoadedMesh4d> read() {
    text_.wordAcrossLines();
    std::int64_t version = 0;
    if (!text_.parse(text_.wordAcrossLines(), version, "the version, 1 to 4")) {
      return text_.error();
    }
    if (version < 1 || version > 4) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("is Medit version {}, expected 1 to 4", version), text_.where());
    }
    std::string_view keyword = text_.wordAcrossLines();
    while (!keyword.empty() && keyword != "End") {
      const auto next = readSection(keyword);
      if (!next) return next.error();
      keyword = *next;
    }
    if (!dimension_) return text_.invalidHere("has no 'Dimension'");
    auto loaded = std::move(mesh_).finish();
    if (!loaded) return loaded;
    loaded->dialect = fmt::format("text, version {}", version);
    loaded->losses = std::move(losses_);
    return loaded;
  }

 private:
  /// Reads the section and returns the keyword after it; empty at the end.
  Result<std::string_view> readSection(std::string_view keyword) {
    if (keyword == "Dimension") {
      if (auto done = readDimension(); !done) return done.error();
    } else if (keyword == "Vertices") {
      if (auto done = readVertices(); !done) return done.error();
    } else if (keyword == "Tetrahedra") {
      if (auto done = readTetrahedra(); !done) return done.error();
    } else {
      return skip(keyword);
    }
    const std::string_view next = text_.wordAcrossLines();
    if (!next.empty() && std::isalpha(static_cast<unsigned char>(next[0])) == 0) {
      return text_.unexpectedWord(next, "a keyword, as 'Tetrahedra' or 'End'");
    }
    return next;
  }

  Result<std::string_view> skip(std::string_view keyword) {
    if (std::isalpha(static_cast<unsigned char>(keyword[0])) == 0) {
      return text_.unexpectedWord(keyword, "a keyword, as 'Vertices'");
    }
    const std::string_view count = text_.wordAcrossLines();
    for (const std::string_view cells :
         {"Hexahedra", "Prisms", "Pyramids", "Triangles", "Quadrilaterals", "Edges"}) {
      if (keyword != cells || count == "0") continue;
      losses_.push_back(fmt::format("{}: {} {} are not read", file_.path.string(), inQuotes(count),
                                    inQuotes(keyword)));
    }
    std::string_view word = count;
    while (!word.empty() && std::isalpha(static_cast<unsigned char>(word[0])) == 0) {
      word = text_.wordAcrossLines();
    }
    return word;
  }

  Result<void> readDimension() {
    std::int64_t dimension = 0;
    if (!text_.parse(text_.wordAcrossLines(), dimension, "the dimension, 4")) {
      return text_.error();
    }
    if (dimension != 4) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("is a mesh of dimension {}, expected 4", dimension), text_.where());
    }
    dimension_ = true;
    return {};
  }

  Result<std::int64_t> readCount(const char* what) {
    std::int64_t count = 0;
    if (!text_.parse(text_.wordAcrossLines(), count, what)) return text_.error();
    if (count < 0 ||
        static_cast<std::uint64_t>(count) > text_.bytesLeft() / kShortestMeditElement + 1) {
      return text_.invalidHere(fmt::format("{} is {}, which the {} bytes that follow cannot hold",
                                           what, count, text_.bytesLeft()));
    }
    return count;
  }

  Result<void> readVertices() {
    if (!dimension_) return text_.invalidHere("'Vertices' comes before 'Dimension'");
    const auto count = readCount("the number of vertices");
    if (!count) return count.error();
    for (std::int64_t i = 0; i < *count; ++i) {
      model::Point4 vertex;
      for (double& coordinate : vertex) {
        if (!text_.parse(text_.wordAcrossLines(), coordinate, "a coordinate")) {
          return text_.error();
        }
      }
      std::int64_t reference = 0;
      if (!text_.parse(text_.wordAcrossLines(), reference, "the reference of a vertex")) {
        return text_.error();
      }
      if (auto added = mesh_.addVertex(vertex, text_.line()); !added) return added;
    }
    return {};
  }

  Result<void> readTetrahedra() {
    const auto count = readCount("the number of tetrahedra");
    if (!count) return count.error();
    for (std::int64_t i = 0; i < *count; ++i) {
      std::array<std::uint64_t, 4> corners{};
      for (std::uint64_t& corner : corners) {
        std::int64_t number = 0;
        if (!text_.parse(text_.wordAcrossLines(), number, "the number of a vertex")) {
          return text_.error();
        }
        if (number < 1) {
          return text_.invalidHere(fmt::format("found vertex {}, expected 1 or more", number));
        }
        corner = static_cast<std::uint64_t>(number) - 1;
      }
      std::int64_t reference = 0;
      if (!text_.parse(text_.wordAcrossLines(), reference, "the reference of a tetrahedron")) {
        return text_.error();
      }
      if (auto added = mesh_.addCell(corners, reference, text_.line()); !added) return added;
    }
    return {};
  }

  const InputFile& file_;
  TextScanner text_;
  Mesh4dBuilder mesh_;
  bool dimension_ = false;
  std::vector<std::string> losses_;
};

}  // namespace

bool isMedit(std::string_view begin) {
  const InputFile file{"", std::string(begin)};
  TextScanner text(file, {.comment = '#'});
  return text.nextLine() && text.word() == kMeditMagic;
}

Result<LoadedMesh4d> readMedit(const InputFile& file) {
  return isMeditBinary(file.bytes) ? readMeditBinary(file) : MeditReader(file).read();
}

}  // namespace t4d::formats
