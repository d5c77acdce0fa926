#include "formats/mesh4d/off4d_reader.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/mesh4d/polyhedron.h"
#include "formats/text/text_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using model::Cell;
using model::Point4;

// The shortest possible lines, with their ends: "0 0 0 0" and "3 0 1 2".
constexpr std::size_t kShortestLine = 8;

/// The header and the numbers after it that are on one line.
struct Off4dHead {
  std::string keyword;
  std::size_t counts = 0;
};

Off4dHead headOf(std::string_view begin) {
  const InputFile file{"", std::string(begin)};
  TextScanner text(file, {.comment = '#'});
  Off4dHead head;
  if (!text.nextLine()) return head;
  head.keyword = text.word();
  if (!text.hasWord() && !text.nextLine()) return head;
  while (text.hasWord()) {
    text.word();
    ++head.counts;
  }
  return head;
}

class OffScanner {
 public:
  OffScanner(const InputFile& file, unsigned counts)
      : text_(file, {.comment = '#'}),
        mesh_(file.path.string(), [&file](auto line) { return file.atLine(line); }) {
    text_.nextLine();
    text_.word();
    counts_.resize(counts);
  }

  Result<void> readCounts(std::initializer_list<const char*> names) {
    if (!text_.hasWord()) text_.nextLine();
    std::size_t i = 0;
    for (const char* name : names) {
      std::int64_t& count = counts_[i++];
      if (!text_.integer(count, name)) return text_.error();
      const bool counted = std::string_view(name) != "the number of edges";
      if (count < 0 ||
          (counted && static_cast<std::uint64_t>(count) > text_.bytesLeft() / kShortestLine + 1)) {
        return text_.invalidHere(fmt::format("{} is {}, which the {} bytes that follow cannot hold",
                                             name, count, text_.bytesLeft()));
      }
    }
    return {};
  }

  std::int64_t count(std::size_t which) const { return counts_[which]; }

  Result<void> readVertices(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      if (auto found = nextLine(i, count, "vertices"); !found) return found;
      Point4 point;
      for (double& coordinate : point) {
        if (!text_.number(coordinate, "a coordinate (a vertex has four)")) {
          return text_.error();
        }
      }
      if (auto added = mesh_.addVertex(point, text_.line()); !added) return added;
    }
    return {};
  }

  /// The next line: a count and so many numbers below `limit`; a colour may follow.
  Result<void> readList(std::int64_t index, std::int64_t count, const char* what,
                        const char* ofWhat, std::int64_t limit, std::vector<std::uint32_t>& into) {
    if (auto found = nextLine(index, count, what); !found) return found;
    std::int64_t size = 0;
    if (!text_.integer(size, "the number of corners")) return text_.error();
    into.clear();
    for (std::int64_t i = 0; i < size; ++i) {
      std::int64_t number = 0;
      if (!text_.integer(number, ofWhat)) return text_.error();
      if (number < 0 || number >= limit) {
        return text_.invalidHere(
            fmt::format("found {}, expected {} from 0 to {}", number, ofWhat, limit - 1));
      }
      into.push_back(static_cast<std::uint32_t>(number));
    }
    return {};
  }

  Result<void> end(const char* after) {
    if (!text_.nextLine()) return {};
    return text_.unexpectedWord(text_.word(), fmt::format("the end of the file after {}", after));
  }

  TextScanner& text() { return text_; }
  Mesh4dBuilder& mesh() { return mesh_; }

 private:
  Result<void> nextLine(std::int64_t index, std::int64_t count, const char* what) {
    if (text_.nextLine()) return {};
    return text_.invalidHere(fmt::format("the file ends after {} of {} {}", index, count, what));
  }

  TextScanner text_;
  Mesh4dBuilder mesh_;
  std::vector<std::int64_t> counts_;
};

/// The faces of a Stella file, one after another.
struct Faces {
  std::vector<std::uint32_t> corners;
  std::vector<std::size_t> begin = {0};
  std::vector<std::uint8_t> uses;  // by cells

  std::span<const std::uint32_t> operator[](std::size_t i) const {
    return std::span(corners).subspan(begin[i], begin[i + 1] - begin[i]);
  }
};

/// The tetrahedron of which face i is opposite corner i; nothing if the faces are not four
/// triangles of four vertices.
std::optional<Cell> tetrahedronOf(std::span<const std::span<const std::uint32_t>> faces) {
  if (faces.size() != 4) return std::nullopt;
  std::vector<std::uint32_t> all;
  for (const auto& face : faces) {
    if (face.size() != 3) return std::nullopt;
    all.insert(all.end(), face.begin(), face.end());
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (all.size() != 4) return std::nullopt;
  Cell cell{};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto opposite = std::ranges::find_if(all, [&](std::uint32_t corner) {
      return std::ranges::find(faces[i], corner) == faces[i].end();
    });
    if (opposite == all.end()) return std::nullopt;
    cell[i] = *opposite;
  }
  return cell;
}

}  // namespace

bool isStellaOff(std::string_view begin) {
  const Off4dHead head = headOf(begin);
  return head.keyword == "4OFF" && head.counts == 4;
}

bool isIjkOff(std::string_view begin) {
  const Off4dHead head = headOf(begin);
  return head.keyword == "4OFF" && head.counts != 4;
}

bool isGeomviewOff(std::string_view begin) {
  const std::string keyword = headOf(begin).keyword;
  return keyword.ends_with("nOFF");
}

Result<LoadedMesh4d> readStellaOff(const InputFile& file) {
  OffScanner off(file, 4);
  if (auto done = off.readCounts({"the number of vertices", "the number of faces",
                                  "the number of edges", "the number of cells"});
      !done) {
    return done.error();
  }
  if (auto done = off.readVertices(off.count(0)); !done) return done.error();
  Faces faces;
  std::vector<std::uint32_t> list;
  for (std::int64_t i = 0; i < off.count(1); ++i) {
    if (auto done = off.readList(i, off.count(1), "faces", "a vertex", off.count(0), list); !done) {
      return done.error();
    }
    if (list.size() < 3) return off.text().invalidHere("a face has fewer than 3 corners");
    faces.corners.insert(faces.corners.end(), list.begin(), list.end());
    faces.begin.push_back(faces.corners.size());
  }
  faces.uses.resize(static_cast<std::size_t>(off.count(1)));
  std::uint64_t split = 0;
  std::vector<std::span<const std::uint32_t>> ofCell;
  for (std::int64_t i = 0; i < off.count(3); ++i) {
    if (auto done = off.readList(i, off.count(3), "cells", "a face", off.count(1), list); !done) {
      return done.error();
    }
    if (list.size() < 4) return off.text().invalidHere("a cell has fewer than 4 faces");
    ofCell.clear();
    for (const std::uint32_t face : list) {
      if (++faces.uses[face] > 2) {
        return off.text().invalidHere(fmt::format("face {} has more than two cells", face));
      }
      ofCell.push_back(faces[face]);
    }
    Result<void> added;
    const auto add = [&](const Cell& cell) {
      if (added)
        added = off.mesh().addCell({cell[0], cell[1], cell[2], cell[3]}, 0, off.text().line());
    };
    if (const auto tetrahedron = tetrahedronOf(ofCell)) {
      add(*tetrahedron);
    } else {
      ++split;
      pullPolyhedron(ofCell, add);
    }
    if (!added) return added.error();
  }
  if (auto done = off.end("the cells"); !done) return done.error();
  auto loaded = std::move(off.mesh()).finish();
  if (!loaded) return loaded;
  loaded->dialect = "Stella";
  if (split > 0) {
    loaded->notices.push_back(fmt::format("{}: {} polyhedral cells are split into tetrahedra",
                                          file.path.string(), split));
  }
  return loaded;
}

Result<LoadedMesh4d> readIjkOff(const InputFile& file) {
  OffScanner off(file, 3);
  if (auto done = off.readCounts(
          {"the number of vertices", "the number of tetrahedra", "the number of edges"});
      !done) {
    return done.error();
  }
  if (auto done = off.readVertices(off.count(0)); !done) return done.error();
  std::vector<std::uint32_t> list;
  bool flat = off.count(1) > 0;
  for (std::int64_t i = 0; i < off.count(1); ++i) {
    if (auto done = off.readList(i, off.count(1), "tetrahedra", "a vertex", off.count(0), list);
        !done) {
      return done.error();
    }
    if (list.size() != 4) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("found an element with {} corners, expected a tetrahedron: this is "
                              "Geomview's OFF, which has polygons and homogeneous coordinates, not "
                              "a 4D mesh",
                              list.size()),
                  off.text().where());
    }
    if (auto added = off.mesh().addCell({list[0], list[1], list[2], list[3]}, 0, off.text().line());
        !added) {
      return added.error();
    }
    if (flat) {
      const auto at = [&](int corner) { return off.mesh().vertices()[list[corner]]; };
      Eigen::Matrix<double, 4, 3> edges;
      for (int k = 0; k < 3; ++k) edges.col(k) = (at(k + 1) - at(0)).stableNormalized();
      // The square of the volume of the parallelepiped; rounding leaves some 1e-16.
      flat = (edges.transpose() * edges).determinant() <= 1e-12;
    }
  }
  if (auto done = off.end("the tetrahedra"); !done) return done.error();
  if (flat) {
    return fail(ErrorCode::Unsupported,
                "all elements are flat: this is Geomview's OFF, which has polygons and homogeneous "
                "coordinates, not a 4D mesh",
                file.path.string());
  }
  auto loaded = std::move(off.mesh()).finish();
  if (loaded) loaded->dialect = "IJK";
  return loaded;
}

Result<LoadedMesh4d> readGeomviewOff(const InputFile& file) {
  return fail(
      ErrorCode::Unsupported,
      "is Geomview's OFF, which has polygons only; a 4D mesh needs tetrahedra, as the OFF of "
      "Stella or IJK has",
      file.path.string());
}

}  // namespace t4d::formats
