#include "formats/mesh4d/vtu_reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/mesh4d/polyhedron.h"
#include "formats/mesh4d/vtu_writer.h"
#include "formats/vtk/vtk_cells.h"
#include "formats/vtk/vtk_data.h"
#include "formats/vtk/vtk_file.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

/// Types of vertices, lines and polygons, straight and curved.
bool isLowerDimension(std::uint32_t type) {
  return type <= 9 || (type >= 21 && type <= 23) || type == 28 || type == 30;
}

/// Whether all cells are tetrahedra, of four corners each.
bool areTetrahedra(const std::vector<std::uint8_t>& types,
                   const std::vector<std::uint32_t>& offsets) {
  std::uint64_t end = 0;
  return std::ranges::all_of(types, [](auto type) { return type == kVtkTetrahedron; }) &&
         std::ranges::all_of(offsets, [&](std::uint32_t offset) { return offset == (end += 4); });
}

class VtuReader {
 public:
  VtuReader(const InputFile& file, VtkFile& vtu)
      : file_(file),
        vtu_(vtu),
        mesh_(file.path.string(),
              [&file](auto index) {
                return placeIn(file.path.string(), fmt::format("element {}", index));
              }),
        data_(vtu) {}

  Result<LoadedMesh4d> read() {
    for (const VtkPiece& piece : vtu_.pieces()) {
      const std::size_t first = mesh_.vertexCount();
      if (auto done = readVertices(piece); !done) return done.error();
      if (auto done = readCells(piece, first); !done) return done.error();
    }
    auto names = readNames();
    if (!names) return names.error();
    mesh_.setAttributes(data_.take(mesh_.vertexCount(), cellCount_));
    auto loaded = std::move(mesh_).finish(*names);
    if (!loaded) return loaded;
    loaded->dialect = vtu_.dialect();
    const std::string path = file_.path.string();
    if (skippedCells_ > 0) {
      loaded->losses.push_back(
          fmt::format("{}: {} cells of lower dimension are not read", path, skippedCells_));
    }
    if (!data_.skipped().empty()) {
      loaded->losses.push_back(
          fmt::format("{}: data that are not read: {}", path, fmt::join(data_.skipped(), ", ")));
    }
    if (pulled_ > 0) {
      loaded->notices.push_back(
          fmt::format("{}: {} polyhedral cells are split into tetrahedra", path, pulled_));
    }
    return loaded;
  }

 private:
  Result<void> readVertices(const VtkPiece& piece) {
    if (piece.points == 0) return {};
    if (piece.coordinates.empty()) return invalid("a piece has no Points", file_.path.string());
    const VtkArray* times = arrayNamed(piece.pointData, "t");
    if (times == nullptr) times = arrayNamed(piece.pointData, "time");
    if (times == nullptr) {
      return invalid(
          "has no point data 't', which would be the fourth coordinate; a surface is an "
          "input of sweep and weave",
          file_.path.string());
    }
    const VtkArray& coordinates = piece.coordinates.front();
    if (coordinates.components != 3) {
      return vtu_.wrong(coordinates,
                        fmt::format("has {} components, expected 3", coordinates.components));
    }
    if (times->components != 1) {
      return vtu_.wrong(*times, fmt::format("has {} components, expected 1", times->components));
    }
    std::vector<model::Point4> vertices;
    if (auto read = vtu_.coordinates(coordinates, 0, vertices, piece.points); !read) return read;
    if (auto read = vtu_.coordinates(*times, 3, vertices, piece.points); !read) return read;
    const std::size_t before = mesh_.vertexCount();
    if (auto added = mesh_.addVertices(std::move(vertices)); !added) return added;
    for (const VtkArray& other : piece.pointData) {
      if (&other != times) data_.add(other, model::Domain::Vertex, piece.points, before);
    }
    return {};
  }

  Result<void> readCells(const VtkPiece& piece, std::size_t first) {
    if (piece.cells.count == 0) return {};
    const VtkArray* ends = arrayNamed(piece.cells.arrays, "offsets");
    const VtkArray* kinds = arrayNamed(piece.cells.arrays, "types");
    const VtkArray* corners = arrayNamed(piece.cells.arrays, "connectivity");
    if (ends == nullptr || kinds == nullptr || corners == nullptr) {
      return invalid("a piece has no Cells with connectivity, offsets and types",
                     file_.path.string());
    }
    constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
    auto offsets = vtu_.indices(*ends, piece.cells.count, kMost);
    if (!offsets) return offsets.error();
    auto types = vtu_.types(*kinds, piece.cells.count);
    if (!types) return types.error();
    if (!std::ranges::is_sorted(*offsets)) return vtu_.wrong(*ends, "goes down");
    std::vector<std::int64_t> bodies;
    const auto isBody = [](const VtkArray& data) {
      return data.name == "body" && data.components == 1 && !data.type.starts_with("Float");
    };
    for (const VtkArray& data : piece.cellData) {
      if (!isBody(data)) continue;
      auto numbers = vtu_.integers(data, piece.cells.count);
      if (!numbers) return numbers.error();
      bodies = std::move(*numbers);
    }
    const std::size_t before = cellCount_;
    const auto readAttributes = [&](std::span<const std::uint32_t> rows) {
      for (const VtkArray& data : piece.cellData) {
        if (!isBody(data)) data_.add(data, model::Domain::Cell, piece.cells.count, before, rows);
      }
    };
    const auto points = static_cast<std::uint32_t>(piece.points);
    if (areTetrahedra(*types, *offsets)) {
      offsets->clear();
      offsets->shrink_to_fit();
      auto cells = vtu_.tetrahedra(*corners, piece.cells.count, points);
      if (!cells) return cells.error();
      if (arrayNamed(vtu_.fieldData(), kOutwardContours) != nullptr) {
        for (model::Cell& cell : *cells) turnOver(cell);
      }
      cellCount_ += cells->size();
      if (auto added = mesh_.addCells(std::move(*cells), first, bodies); !added) return added;
      readAttributes({});
      return {};
    }
    const auto all = vtu_.indices(*corners, offsets->back(), points);
    if (!all) return all.error();
    mesh_.reserve(0, piece.cells.count);
    std::size_t begin = 0;
    std::vector<std::uint32_t> cellOf;  // of each tetrahedron added
    for (std::size_t i = 0; i < piece.cells.count; ++i) {
      const std::size_t end = (*offsets)[i];
      const std::span<const std::uint32_t> cell(all->data() + begin, end - begin);
      begin = end;
      auto added = addCell((*types)[i], cell, first, bodies.empty() ? 0 : bodies[i], i);
      if (!added) return added;
      cellOf.resize(cellCount_ - before, static_cast<std::uint32_t>(i));
    }
    readAttributes(cellOf);
    return {};
  }

  Result<void> addCell(std::uint32_t type, std::span<const std::uint32_t> corners,
                       std::size_t first, std::int64_t body, std::size_t index) {
    const auto at = [&](std::size_t i) { return first + corners[i]; };
    const auto wrongCount = [&](std::size_t expected) {
      return invalid(fmt::format("cell {} of type {} has {} corners, expected {}", index, type,
                                 corners.size(), expected),
                     file_.path.string());
    };
    if (type == kVtkTetrahedron) {
      if (corners.size() != 4) return wrongCount(4);
      ++cellCount_;
      return mesh_.addCell({at(0), at(1), at(2), at(3)}, body, index);
    }
    if (isLowerDimension(type)) {
      ++skippedCells_;
      return {};
    }
    const VtkSolidShape* shape = vtkSolidShape(type);
    if (shape == nullptr) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("cell {} has the type {}, which is not supported; tetrahedra (10) are", index,
                      type),
          file_.path.string());
    }
    if (corners.size() != shape->corners) return wrongCount(shape->corners);
    ++pulled_;
    std::vector<std::vector<std::uint32_t>> faces = shape->faces;
    for (auto& face : faces) {
      for (std::uint32_t& corner : face) corner = static_cast<std::uint32_t>(at(corner));
    }
    const std::vector<std::span<const std::uint32_t>> solid(faces.begin(), faces.end());
    Result<void> added;
    pullPolyhedron(solid, [&](const model::Cell& cell) {
      ++cellCount_;
      if (added) added = mesh_.addCell({cell[0], cell[1], cell[2], cell[3]}, body, index);
    });
    return added;
  }

  /// The names of bodies 0, 1, ...: bytes, each name with a 0 after it.
  Result<std::map<std::int64_t, std::string>> readNames() {
    std::map<std::int64_t, std::string> names;
    for (const VtkArray& data : vtu_.fieldData()) {
      if (data.name == kOutwardContours) continue;
      if (data.name != "body_names") {
        data_.skip(data.name);
        continue;
      }
      const auto text = vtu_.strings(data);
      if (!text) return text.error();
      std::string name;
      for (const char c : *text) {
        if (c != 0) {
          name += c;
          continue;
        }
        names.emplace(static_cast<std::int64_t>(names.size()), name);
        name.clear();
      }
    }
    return names;
  }

  const InputFile& file_;
  VtkFile& vtu_;
  Mesh4dBuilder mesh_;
  VtkData data_;
  std::size_t cellCount_ = 0;
  std::uint64_t skippedCells_ = 0;
  std::uint64_t pulled_ = 0;
};

}  // namespace

bool isVtu(std::string_view begin) {
  return begin.find("<VTKFile") != begin.npos && begin.find("UnstructuredGrid") != begin.npos;
}

Result<LoadedMesh4d> readVtu(const InputFile& file) {
  auto vtu = VtkFile::open(file, VtkType::UnstructuredGrid);
  if (!vtu) return vtu.error();
  return VtuReader(file, *vtu).read();
}

}  // namespace t4d::formats
