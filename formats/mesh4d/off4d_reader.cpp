#include "formats/mesh4d/off4d_reader.h"

#include <cmath>

#include <fmt/format.h>

#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/mesh4d/polyhedra.h"
#include "formats/text/text_scanner.h"
#include "model/number.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

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

Result<void> readFaces(OffScanner& off, Polyhedra& polyhedra) {
  std::vector<std::uint32_t> list;
  for (std::int64_t i = 0; i < off.count(1); ++i) {
    if (auto done = off.readList(i, off.count(1), "faces", "a vertex", off.count(0), list); !done) {
      return done;
    }
    if (list.size() < 3) return off.text().invalidHere("a face has fewer than 3 corners");
    polyhedra.addFace(list);
  }
  return {};
}

Result<void> readCells(OffScanner& off, Polyhedra& polyhedra) {
  std::vector<std::uint8_t> uses(static_cast<std::size_t>(off.count(1)));
  std::vector<std::uint32_t> list;
  for (std::int64_t i = 0; i < off.count(3); ++i) {
    if (auto done = off.readList(i, off.count(3), "cells", "a face", off.count(1), list); !done) {
      return done;
    }
    if (list.size() < 4) return off.text().invalidHere("a cell has fewer than 4 faces");
    for (const std::uint32_t face : list) {
      if (++uses[face] > 2) {
        return off.text().invalidHere(fmt::format("face {} has more than two cells", face));
      }
    }
    polyhedra.addCell(list);
  }
  return {};
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

std::optional<unsigned> otherOffRank(std::string_view begin) {
  const std::string keyword = headOf(begin).keyword;
  if (!keyword.ends_with("OFF")) return std::nullopt;
  const auto rank = model::numberIn<unsigned>(keyword.substr(0, keyword.size() - 3));
  return rank == 4U ? std::nullopt : rank;
}

Result<LoadedMesh4d> readStellaOff(const InputFile& file) {
  OffScanner off(file, 4);
  if (auto done = off.readCounts({"the number of vertices", "the number of faces",
                                  "the number of edges", "the number of cells"});
      !done) {
    return done.error();
  }
  if (auto done = off.readVertices(off.count(0)); !done) return done.error();
  Polyhedra polyhedra;
  if (auto done = readFaces(off, polyhedra); !done) return done.error();
  if (auto done = readCells(off, polyhedra); !done) return done.error();
  if (auto done = off.end("the cells"); !done) return done.error();
  auto notice = polyhedra.addTo(off.mesh());
  if (!notice) return notice.error();
  auto loaded = std::move(off.mesh()).finish();
  if (!loaded) return loaded;
  loaded->dialect = "Stella";
  if (!notice->empty()) {
    loaded->notices.push_back(fmt::format("{}: {}", file.path.string(), *notice));
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
