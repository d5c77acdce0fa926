#include "t4d/formats/mesh4d/vtu_reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "t4d/formats/mesh4d/mesh4d_builder.h"
#include "t4d/formats/mesh4d/polyhedron.h"
#include "t4d/formats/mesh4d/vtu_file.h"
#include "t4d/formats/mesh4d/vtu_writer.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/model/attribute_rows.h"

namespace t4d::formats {
namespace {

constexpr std::uint8_t kTetrahedronType = 10;

/// A VTK cell with flat faces, by the numbers of its corners.
struct Shape {
  std::size_t corners;
  std::vector<std::vector<std::uint32_t>> faces;
};

const std::map<std::uint32_t, Shape>& shapes() {
  static const std::map<std::uint32_t, Shape> all = {
      {11,
       {8, {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}}}},
      {12,
       {8, {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}},
      {13, {6, {{0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}}},
      {14, {5, {{0, 1, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}}},
  };
  return all;
}

/// Types of vertices, lines and polygons, straight and curved.
bool isLowerDimension(std::uint32_t type) {
  return type <= 9 || (type >= 21 && type <= 23) || type == 28 || type == 30;
}

/// Whether all cells are tetrahedra, of four corners each.
bool areTetrahedra(const std::vector<std::uint8_t>& types,
                   const std::vector<std::uint32_t>& offsets) {
  std::uint64_t end = 0;
  return std::ranges::all_of(types, [](auto type) { return type == kTetrahedronType; }) &&
         std::ranges::all_of(offsets, [&](std::uint32_t offset) { return offset == (end += 4); });
}

const VtuArray* named(const std::vector<VtuArray>& arrays, std::string_view name) {
  const auto found = std::ranges::find(arrays, name, &VtuArray::name);
  return found == arrays.end() ? nullptr : &*found;
}

class VtuReader {
 public:
  VtuReader(const InputFile& file, VtuFile& vtu)
      : file_(file), vtu_(vtu), mesh_(file.path.string(), [&file](auto index) {
          return fmt::format("{}: element {}", file.path.string(), index);
        }) {}

  Result<LoadedMesh4d> read() {
    for (const VtuPiece& piece : vtu_.pieces()) {
      const std::size_t first = mesh_.vertexCount();
      if (auto done = readVertices(piece); !done) return pass(done.error());
      if (auto done = readCells(piece, first); !done) return pass(done.error());
    }
    auto names = readNames();
    if (!names) return pass(names.error());
    std::vector<model::Attribute> attributes;
    for (const auto& [some, rows] :
         {std::pair{&ofVertices_, mesh_.vertexCount()}, std::pair{&ofCells_, cellCount_}}) {
      for (auto& [name, attribute] : *some) {
        if (attribute.rows() == rows) {
          attributes.push_back(std::move(attribute));
        } else {
          skippedData_.insert(name);  // a piece does not have it
        }
      }
    }
    mesh_.setAttributes(std::move(attributes));
    auto loaded = std::move(mesh_).finish(*names);
    if (!loaded) return loaded;
    loaded->dialect = vtu_.dialect();
    const std::string path = file_.path.string();
    if (skippedCells_ > 0) {
      loaded->losses.push_back(
          fmt::format("{}: {} cells of lower dimension are not read", path, skippedCells_));
    }
    if (!skippedData_.empty()) {
      loaded->losses.push_back(
          fmt::format("{}: data that are not read: {}", path, fmt::join(skippedData_, ", ")));
    }
    if (pulled_ > 0) {
      loaded->notices.push_back(
          fmt::format("{}: {} polyhedral cells are split into tetrahedra", path, pulled_));
    }
    return loaded;
  }

 private:
  Result<void> readVertices(const VtuPiece& piece) {
    if (piece.points == 0) return {};
    if (piece.coordinates.empty()) return invalid("a piece has no Points", file_.path.string());
    const VtuArray* times = named(piece.pointData, "t");
    if (times == nullptr) times = named(piece.pointData, "time");
    if (times == nullptr) {
      return invalid("has no point data 't', which would be the fourth coordinate",
                     file_.path.string());
    }
    const VtuArray& coordinates = piece.coordinates.front();
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
    for (const VtuArray& other : piece.pointData) {
      if (&other != times) readAttribute(other, model::Domain::Vertex, piece.points, before, {});
    }
    return {};
  }

  Result<void> readCells(const VtuPiece& piece, std::size_t first) {
    if (piece.cells == 0) return {};
    const VtuArray* ends = named(piece.connectivity, "offsets");
    const VtuArray* kinds = named(piece.connectivity, "types");
    const VtuArray* corners = named(piece.connectivity, "connectivity");
    if (ends == nullptr || kinds == nullptr || corners == nullptr) {
      return invalid("a piece has no Cells with connectivity, offsets and types",
                     file_.path.string());
    }
    constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
    auto offsets = vtu_.indices(*ends, piece.cells, kMost);
    if (!offsets) return pass(offsets.error());
    auto types = vtu_.types(*kinds, piece.cells);
    if (!types) return pass(types.error());
    if (!std::ranges::is_sorted(*offsets)) return vtu_.wrong(*ends, "goes down");
    std::vector<std::int64_t> bodies;
    const auto isBody = [](const VtuArray& data) {
      return data.name == "body" && data.components == 1 && !data.type.starts_with("Float");
    };
    for (const VtuArray& data : piece.cellData) {
      if (!isBody(data)) continue;
      auto numbers = vtu_.integers(data, piece.cells);
      if (!numbers) return pass(numbers.error());
      bodies = std::move(*numbers);
    }
    const std::size_t before = cellCount_;
    const auto readAttributes = [&](std::span<const std::uint32_t> rows) {
      for (const VtuArray& data : piece.cellData) {
        if (!isBody(data)) readAttribute(data, model::Domain::Cell, piece.cells, before, rows);
      }
    };
    const auto points = static_cast<std::uint32_t>(piece.points);
    if (areTetrahedra(*types, *offsets)) {
      offsets->clear();
      offsets->shrink_to_fit();
      auto cells = vtu_.tetrahedra(*corners, piece.cells, points);
      if (!cells) return pass(cells.error());
      if (named(vtu_.fieldData(), kOutwardContours) != nullptr) {
        for (model::Cell& cell : *cells) turnOver(cell);
      }
      cellCount_ += cells->size();
      if (auto added = mesh_.addCells(std::move(*cells), first, bodies); !added) return added;
      readAttributes({});
      return {};
    }
    const auto all = vtu_.indices(*corners, offsets->back(), points);
    if (!all) return pass(all.error());
    mesh_.reserve(0, piece.cells);
    std::size_t begin = 0;
    std::vector<std::uint32_t> cellOf;  // of each tetrahedron added
    for (std::size_t i = 0; i < piece.cells; ++i) {
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
    if (type == kTetrahedronType) {
      if (corners.size() != 4) return wrongCount(4);
      ++cellCount_;
      return mesh_.addCell({at(0), at(1), at(2), at(3)}, body, index);
    }
    if (isLowerDimension(type)) {
      ++skippedCells_;
      return {};
    }
    const auto shape = shapes().find(type);
    if (shape == shapes().end()) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("cell {} has the type {}, which is not supported; tetrahedra (10) are", index,
                      type),
          file_.path.string());
    }
    if (corners.size() != shape->second.corners) return wrongCount(shape->second.corners);
    ++pulled_;
    std::vector<std::vector<std::uint32_t>> faces = shape->second.faces;
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

  /// Reads an attribute of a piece, of which `before` rows are known from those before it. `rows`
  /// are those that the mesh has, if they are not all.
  void readAttribute(const VtuArray& data, model::Domain domain, std::uint64_t count,
                     std::size_t before, std::span<const std::uint32_t> rows) {
    auto& known = domain == model::Domain::Vertex ? ofVertices_ : ofCells_;
    constexpr std::uint64_t kMostComponents = 255;  // of .t4d
    const bool good = checkName(data.name) && VtuFile::scalarTypeOf(data) && data.components > 0 &&
                      data.components <= kMostComponents && skippedData_.count(data.name) == 0;
    auto read = good ? vtu_.attribute(data, domain, count) : Result<model::Attribute>();
    if (read && !rows.empty()) *read = rowsOf(*read, rows);
    if (good && read && before == 0 && known.count(data.name) == 0) {
      known.emplace(data.name, std::move(*read));
      return;
    }
    const auto found = known.find(data.name);
    if (good && read && found != known.end() && found->second.rows() == before &&
        found->second.type == read->type && found->second.components == read->components) {
      found->second.values.insert(found->second.values.end(), read->values.begin(),
                                  read->values.end());
      return;
    }
    known.erase(data.name);
    skippedData_.insert(data.name);
  }

  /// The names of bodies 0, 1, ...: bytes, each name with a 0 after it.
  Result<std::map<std::int64_t, std::string>> readNames() {
    std::map<std::int64_t, std::string> names;
    for (const VtuArray& data : vtu_.fieldData()) {
      if (data.name == kOutwardContours) continue;
      if (data.name != "body_names") {
        skippedData_.insert(data.name);
        continue;
      }
      const auto text = vtu_.strings(data);
      if (!text) return pass(text.error());
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
  VtuFile& vtu_;
  Mesh4dBuilder mesh_;
  std::map<std::string, model::Attribute> ofVertices_;
  std::map<std::string, model::Attribute> ofCells_;
  std::size_t cellCount_ = 0;
  std::uint64_t skippedCells_ = 0;
  std::uint64_t pulled_ = 0;
  std::set<std::string> skippedData_;
};

}  // namespace

bool isVtu(std::string_view begin) { return begin.find("<VTKFile") != begin.npos; }

Result<LoadedMesh4d> readVtu(const InputFile& file) {
  auto vtu = VtuFile::open(file);
  if (!vtu) return pass(vtu.error());
  return VtuReader(file, *vtu).read();
}

}  // namespace t4d::formats
