#include "formats/mesh4d/mfem_reader.h"

#include <algorithm>
#include <array>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/text/text_scanner.h"
#include "model/exact_sum.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using model::Cell;

// Numbers of geometries.
constexpr std::int64_t kTetrahedron = 4;
/// The numbers of pentatopes: in MFEM's branch of 4D, in its later branch 4d_dev, and in MFEM
/// itself.
constexpr std::array<std::int64_t, 3> kPentatopes = {6, 7, 8};

// The shortest possible line, with its end: "0 0 0 0" of a vertex.
constexpr std::size_t kShortestMfemLine = 8;

class MfemReader {
 public:
  explicit MfemReader(const InputFile& file)
      : file_(file),
        text_(file, {.comment = '#'}),
        mesh_(file.path.string(), [&file](auto line) { return file.atLine(line); }) {}

  Result<LoadedMesh4d> read() {
    text_.nextLine();
    const std::string_view title = text_.rest();
    if (title != "MFEM mesh v1.0") {
      return fail(ErrorCode::Unsupported,
                  fmt::format("found {}, expected 'MFEM mesh v1.0'", inQuotes(title)),
                  text_.where());
    }
    for (auto word = text_.wordAcrossLines(); !word.empty(); word = text_.wordAcrossLines()) {
      Result<void> done;
      if (word == "dimension") {
        done = readDimension();
      } else if (word == "elements") {
        done = readElements(kPentatopes, "elements");
      } else if (word == "boundary") {
        done = readElements(std::array{kTetrahedron}, "boundary elements");
      } else if (word == "vertices") {
        done = readVertices();
      } else if (word == "nodes") {
        return fail(ErrorCode::Unsupported,
                    "has curved elements ('nodes'), which are not supported", text_.where());
      } else if (word == "mfem_mesh_end") {
        break;
      } else {
        return text_.unexpectedWord(word, "'elements', 'boundary' or 'vertices'");
      }
      if (!done) return done.error();
    }
    const bool made = boundaryCount_ == 0;
    if (made) {
      if (auto done = addBoundaryOfElements(); !done) return done.error();
    }
    auto loaded = std::move(mesh_).finish();
    if (!loaded) return loaded;
    loaded->dialect = made ? "boundary of pentatopes" : "boundary elements";
    if (!elements_.empty()) {
      // Vertices inside are dropped: they are no part of the boundary.
      loaded->notices.clear();
      loaded->losses.push_back(fmt::format("{}: only the boundary of the {} pentatopes is read",
                                           file_.path.string(), elements_.size()));
    }
    return loaded;
  }

 private:
  Result<void> readDimension() {
    std::int64_t dimension = 0;
    if (!text_.parse(text_.wordAcrossLines(), dimension, "the dimension, 4")) {
      return text_.error();
    }
    if (dimension == 4) return {};
    return fail(ErrorCode::Unsupported,
                fmt::format("is a mesh of dimension {}, expected 4", dimension), text_.where());
  }

  Result<std::int64_t> readCount(const char* what) {
    std::int64_t count = 0;
    if (!text_.parse(text_.wordAcrossLines(), count, what)) return text_.error();
    if (count < 0 ||
        static_cast<std::uint64_t>(count) > text_.bytesLeft() / kShortestMfemLine + 1) {
      return text_.invalidHere(fmt::format("{} is {}, which the {} bytes that follow cannot hold",
                                           what, count, text_.bytesLeft()));
    }
    return count;
  }

  Result<void> readElements(std::span<const std::int64_t> geometries, const char* what) {
    const bool pentatopes = geometries.size() > 1;
    const auto count = readCount("the number of elements");
    if (!count) return count.error();
    for (std::int64_t i = 0; i < *count; ++i) {
      if (!text_.nextLine()) {
        return text_.invalidHere(fmt::format("the file ends after {} of {} {}", i, *count, what));
      }
      std::int64_t attribute = 0;
      std::int64_t found = 0;
      if (!text_.integer(attribute, "an attribute") || !text_.integer(found, "a geometry")) {
        return text_.error();
      }
      if (std::ranges::find(geometries, found) == geometries.end()) {
        return fail(
            ErrorCode::Unsupported,
            fmt::format("found geometry {}, expected {} ({})", found, fmt::join(geometries, " or "),
                        pentatopes ? "pentatope" : "tetrahedron"),
            text_.where());
      }
      std::array<std::uint64_t, 5> corners{};
      const std::size_t size = pentatopes ? 5 : 4;
      for (std::size_t k = 0; k < size; ++k) {
        std::int64_t number = 0;
        if (!text_.integer(number, "the number of a vertex")) return text_.error();
        if (number < 0) {
          return text_.invalidHere(fmt::format("found vertex {}, expected 0 or more", number));
        }
        corners[k] = static_cast<std::uint64_t>(number);
      }
      if (pentatopes) {
        elements_.push_back({corners, text_.line()});
        continue;
      }
      ++boundaryCount_;
      auto added =
          mesh_.addCell({corners[0], corners[1], corners[2], corners[3]}, attribute, text_.line());
      if (!added) return added;
    }
    return {};
  }

  Result<void> readVertices() {
    const auto count = readCount("the number of vertices");
    if (!count) return count.error();
    const std::string_view word = text_.wordAcrossLines();
    if (word == "nodes") {
      return fail(ErrorCode::Unsupported, "has curved elements ('nodes'), which are not supported",
                  text_.where());
    }
    std::int64_t dimension = 0;
    if (!text_.parse(word, dimension, "the number of coordinates, 4")) return text_.error();
    if (dimension != 4) {
      return text_.invalidHere(
          fmt::format("has vertices of {} coordinates, expected 4", dimension));
    }
    for (std::int64_t i = 0; i < *count; ++i) {
      model::Point4 vertex;
      for (double& coordinate : vertex) {
        if (!text_.parse(text_.wordAcrossLines(), coordinate, "a coordinate")) {
          return text_.error();
        }
      }
      if (auto added = mesh_.addVertex(vertex, text_.line()); !added) return added;
    }
    return {};
  }

  struct Element {
    std::array<std::uint64_t, 5> corners;
    std::uint64_t line;
  };

  /// A side of a pentatope, with its corners sorted to find the other pentatope beside it.
  struct Side {
    std::array<std::uint64_t, 4> sorted;
    std::array<std::uint64_t, 4> corners;
    std::uint64_t line;
  };

  Result<void> addBoundaryOfElements() {
    std::vector<Side> sides;
    sides.reserve(5 * elements_.size());
    const auto vertices = mesh_.vertices();
    for (const auto& [corners, line] : elements_) {
      for (const std::uint64_t corner : corners) {
        if (corner < vertices.size()) continue;
        return invalid(
            fmt::format("an element refers to vertex {}, but there are {}, numbered from "
                        "0",
                        corner, vertices.size()),
            file_.atLine(line));
      }
      std::array<model::Point4, 5> points;
      for (std::size_t i = 0; i < 5; ++i) points[i] = vertices[corners[i]];
      const int sign = model::orientationSign(points);
      if (sign == 0) return invalid("a pentatope is flat", file_.atLine(line));
      for (std::size_t out = 0; out < 5; ++out) {
        Side side{{}, {}, line};
        for (std::size_t i = 0, k = 0; i < 5; ++i) {
          if (i != out) side.corners[k++] = corners[i];
        }
        // Side 0 of a positive pentatope faces outward; the others take turns.
        if ((sign > 0) != (out % 2 == 0)) std::swap(side.corners[2], side.corners[3]);
        side.sorted = side.corners;
        std::ranges::sort(side.sorted);
        sides.push_back(side);
      }
    }
    std::ranges::sort(sides, {}, &Side::sorted);
    for (auto at = sides.begin(); at != sides.end();) {
      const auto end = std::find_if(at, sides.end(),
                                    [&](const Side& side) { return side.sorted != at->sorted; });
      if (end - at > 2) {
        return invalid("a tetrahedron is a side of more than two pentatopes",
                       file_.atLine(at[2].line));
      }
      if (end - at == 1) {
        if (auto added = mesh_.addCell(at->corners, 0, at->line); !added) return added;
      }
      at = end;
    }
    return {};
  }

  const InputFile& file_;
  TextScanner text_;
  Mesh4dBuilder mesh_;
  std::vector<Element> elements_;
  std::uint64_t boundaryCount_ = 0;
};

}  // namespace

bool isMfem(std::string_view begin) { return begin.starts_with("MFEM mesh v1."); }

Result<LoadedMesh4d> readMfem(const InputFile& file) { return MfemReader(file).read(); }

}  // namespace t4d::formats
