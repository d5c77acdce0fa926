#include "formats/mesh4d/tetgen_reader.h"

#include <array>
#include <map>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/text/text_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

// The shortest possible line, with its end: "0 0 0 0 0".
constexpr std::size_t kShortestTetGenLine = 10;

class TetGenReader {
 public:
  TetGenReader(const InputFile& nodes, const InputFile& elements)
      : nodes_(nodes, {.comment = '#'}),
        elements_(elements, {.comment = '#'}),
        mesh_(elements.path.string(),
              [&](auto line) { return (inElements_ ? elements : nodes).atLine(line); }) {}

  Result<LoadedMesh4d> read() {
    if (auto done = readNodes(); !done) return done.error();
    inElements_ = true;
    if (auto done = readElements(); !done) return done.error();
    return std::move(mesh_).finish();
  }

 private:
  /// The first line: a count, and up to three further numbers, 0 where they are left out.
  static Result<std::array<std::int64_t, 4>> readHead(TextScanner& text, const char* what) {
    std::array<std::int64_t, 4> head{};
    if (!text.nextLine()) return text.invalidHere("the file is empty");
    if (!text.integer(head[0], what)) return text.error();
    for (int i = 1; i < 4 && text.hasWord(); ++i) {
      if (!text.integer(head[i], "a whole number")) return text.error();
    }
    if (head[0] < 0 ||
        static_cast<std::uint64_t>(head[0]) > text.bytesLeft() / kShortestTetGenLine + 1) {
      return text.invalidHere(fmt::format("{} is {}, which the {} bytes that follow cannot hold",
                                          what, head[0], text.bytesLeft()));
    }
    return head;
  }

  /// Reads the number of a line, which must be `expected`; the first one is 0 or 1.
  Result<void> readNumber(TextScanner& text, std::int64_t index, std::int64_t count) {
    if (!text.nextLine()) {
      return text.invalidHere(fmt::format("the file ends after {} of {} lines", index, count));
    }
    std::int64_t number = 0;
    if (!text.integer(number, "the number of the line")) return text.error();
    if (&text == &nodes_ && index == 0 && (number == 0 || number == 1)) first_ = number;
    if (number != index + first_) {
      return text.invalidHere(fmt::format("found number {}, expected {}", number, index + first_));
    }
    return {};
  }

  Result<void> readNodes() {
    const auto head = readHead(nodes_, "the number of points");
    if (!head) return head.error();
    if ((*head)[1] != 3 || (*head)[2] != 1) {
      return nodes_.invalidHere(fmt::format(
          "has points of dimension {} with {} attributes, expected 3 and 1: x, y, z and "
          "the time",
          (*head)[1], (*head)[2]));
    }
    for (std::int64_t i = 0; i < (*head)[0]; ++i) {
      if (auto done = readNumber(nodes_, i, (*head)[0]); !done) return done;
      model::Point4 vertex;
      for (int axis = 0; axis < 4; ++axis) {
        const char* what = axis < 3 ? "a coordinate" : "an attribute, the time";
        if (!nodes_.number(vertex[axis], what)) return nodes_.error();
      }
      if (auto added = mesh_.addVertex(vertex, nodes_.line()); !added) return added;
    }
    return {};
  }

  Result<void> readElements() {
    const auto head = readHead(elements_, "the number of tetrahedra");
    if (!head) return head.error();
    if ((*head)[1] != 4) {
      return elements_.invalidHere(fmt::format("has elements of {} nodes, expected 4", (*head)[1]));
    }
    // Regions may be any numbers.
    std::map<double, std::int64_t> regions;
    for (std::int64_t i = 0; i < (*head)[0]; ++i) {
      if (auto done = readNumber(elements_, i, (*head)[0]); !done) return done;
      std::array<std::uint64_t, 4> corners{};
      for (std::uint64_t& corner : corners) {
        std::int64_t number = 0;
        if (!elements_.integer(number, "the number of a point")) return elements_.error();
        if (number < first_ || static_cast<std::uint64_t>(number - first_) >= mesh_.vertexCount()) {
          return elements_.invalidHere(
              fmt::format("a tetrahedron refers to point {}, but there are {}, numbered from {}",
                          number, mesh_.vertexCount(), first_));
        }
        corner = static_cast<std::uint64_t>(number - first_);
      }
      double region = 0;
      if ((*head)[2] > 0 && !elements_.number(region, "an attribute, the region")) {
        return elements_.error();
      }
      const auto part = regions.try_emplace(region, regions.size()).first->second;
      if (auto added = mesh_.addCell(corners, part, elements_.line()); !added) return added;
    }
    return {};
  }

  TextScanner nodes_;
  TextScanner elements_;
  bool inElements_ = false;
  Mesh4dBuilder mesh_;
  std::int64_t first_ = 0;
};

}  // namespace

Result<LoadedMesh4d> readTetGen(const InputFile& nodes, const InputFile& elements) {
  return TetGenReader(nodes, elements).read();
}

Result<LoadedMesh4d> readTetGen(const InputFile& file) {
  const bool isElements = lowerCaseExtension(file.path) == ".ele";
  std::filesystem::path otherPath = file.path;
  otherPath.replace_extension(isElements ? ".node" : ".ele");
  const auto other = readInputFile(otherPath);
  if (!other) {
    Error error = other.error();
    error.message += fmt::format("; it has the {} of {}", isElements ? "points" : "tetrahedra",
                                 file.path.string());
    return error;
  }
  auto loaded = isElements ? readTetGen(*other, file) : readTetGen(file, *other);
  if (loaded) loaded->otherFiles.push_back(otherPath);
  return loaded;
}

}  // namespace t4d::formats
