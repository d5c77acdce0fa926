#include "formats/vtk/vtk_surface_reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/triangle/mesh_builder.h"
#include "formats/vtk/vtk_cells.h"
#include "formats/vtk/vtk_data.h"
#include "formats/vtk/vtk_file.h"
#include "model/attribute_rows.h"
#include "t4d/mesh.h"

namespace t4d::formats {
namespace {

/// The place of what is no cell.
constexpr MeshBuilder::Position kNoCell = ~std::uint64_t{0};
/// Bits of vtkGhostType: a duplicate, replaced by finer cells, hidden.
constexpr std::int64_t kLeftOut = 1 | 8 | 32;

constexpr const char* kNormals = "Normals";
constexpr const char* kGhosts = "vtkGhostType";

/// Cells by the ends of their corners.
struct Cells {
  std::vector<std::uint32_t> ends;
  std::vector<std::uint32_t> corners;

  std::span<const std::uint32_t> at(std::size_t cell) const {
    const std::size_t begin = cell == 0 ? 0 : ends[cell - 1];
    return std::span(corners).subspan(begin, ends[cell] - begin);
  }
};

/// The cells of a piece of an unstructured grid.
struct SurfaceGrid {
  Cells cells;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> ghosts;
  std::size_t firstPoint = 0;
  std::size_t firstRow = 0;
};

/// A face of a solid cell.
struct Face {
  std::array<std::uint32_t, 4> points;  ///< in ascending order
  std::uint32_t grid;
  std::uint32_t cell;
  std::uint32_t number;  ///< of the faces of the cell
};

bool isLeftOut(const std::vector<std::int64_t>& ghosts, std::size_t cell) {
  return !ghosts.empty() && (ghosts[cell] & kLeftOut) != 0;
}

/// Types of vertices and lines, straight and curved, and of cells without corners.
bool isPointOrLine(std::uint32_t type) {
  return type <= 4 || type == 21 || type == 35 || type == 68 || type == 75;
}

/// The number of corners of flat cells of two dimensions; 0 if it is not fixed, nothing for others.
std::optional<std::size_t> cornersOfFlat(std::uint32_t type) {
  switch (type) {
    case kVtkTriangle:
      return 3;
    case kVtkPixel:
    case kVtkQuad:
      return 4;
    case kVtkStrip:
    case kVtkPolygon:
      return 0;
    default:
      return std::nullopt;
  }
}

class VtkSurfaceReader {
 public:
  VtkSurfaceReader(const InputFile& file, VtkFile& vtk, Keep keep)
      : keep_(keep),
        path_(file.path.string()),
        vtk_(vtk),
        data_(vtk),
        builder_(path_, [this](auto cell) { return placeOf(cell); }) {}

  Result<LoadedMesh> readPolyData() {
    for (const VtkPiece& piece : vtk_.pieces()) {
      if (auto done = addPolyData(piece); !done) return done.error();
    }
    return finish();
  }

  Result<LoadedMesh> readGrid() {
    std::vector<SurfaceGrid> grids;
    for (const VtkPiece& piece : vtk_.pieces()) {
      auto grid = gridOf(piece);
      if (!grid) return grid.error();
      grids.push_back(std::move(*grid));
    }
    for (const SurfaceGrid& grid : grids) {
      if (auto good = checkTypes(grid); !good) return good.error();
    }
    auto added = solids_ > 0 ? addBoundary(grids) : addFlatCells(grids);
    if (!added) return added.error();
    grids.clear();
    return finish();
  }

 private:
  Place placeOf(MeshBuilder::Position cell) const {
    return cell == kNoCell ? Place(path_) : placeIn(path_, fmt::format("cell {}", cell));
  }

  /// Adds the points of a piece and its data; `cells` is how many the data of cells are of.
  Result<void> addPoints(const VtkPiece& piece, std::uint64_t cells) {
    if (rows_ + cells > std::numeric_limits<std::uint32_t>::max()) {
      return fail(ErrorCode::Unsupported, "holds more cells than 32-bit indices can count", path_);
    }
    const std::size_t before = builder_.pointCount();
    if (piece.points > 0) {
      if (piece.coordinates.empty()) return invalid("a piece has no Points", path_);
      const VtkArray& coordinates = piece.coordinates.front();
      if (coordinates.components != 3) {
        return vtk_.wrong(coordinates,
                          fmt::format("has {} components, expected 3", coordinates.components));
      }
      std::vector<model::Point3> points;
      if (auto read = vtk_.coordinates(coordinates, 0, points, piece.points); !read) return read;
      if (before == 0) builder_.reserve(points.size(), 0);
      for (const model::Point3& point : points) {
        if (auto added = builder_.addPoint(point, kNoCell); !added) return added;
      }
    }
    for (const VtkArray& data : piece.pointData) {
      if (data.name == piece.textureCoordinates) looks_.insert(data.name);
      if (data.name == piece.normals || !isKept(data)) continue;
      data_.add(data, model::Domain::Vertex, piece.points, before);
    }
    for (const VtkArray& data : piece.cellData) {
      if (isKept(data)) data_.add(data, model::Domain::Cell, cells, rows_);
    }
    return {};
  }

  static bool isKept(const VtkArray& data) { return data.name != kNormals && data.name != kGhosts; }

  /// What `vtkGhostType` says of the cells of a piece; nothing if there is none.
  Result<std::vector<std::int64_t>> ghostsOf(const VtkPiece& piece, std::uint64_t cells) {
    const VtkArray* ghosts = arrayNamed(piece.cellData, kGhosts);
    if (ghosts == nullptr || cells == 0) return std::vector<std::int64_t>();
    return vtk_.integers(*ghosts, cells);
  }

  Result<Cells> cellsOf(const VtkCells& of, std::uint64_t points) {
    if (of.count == 0) return Cells();
    const VtkArray* ends = arrayNamed(of.arrays, "offsets");
    const VtkArray* corners = arrayNamed(of.arrays, "connectivity");
    if (ends == nullptr || corners == nullptr) {
      return invalid("a piece has cells without connectivity and offsets", path_);
    }
    constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
    auto offsets = vtk_.indices(*ends, of.count, kMost);
    if (!offsets) return offsets.error();
    if (!std::ranges::is_sorted(*offsets)) return vtk_.wrong(*ends, "goes down");
    auto all = vtk_.indices(*corners, offsets->back(), static_cast<std::uint32_t>(points));
    if (!all) return all.error();
    return Cells{std::move(*offsets), std::move(*all)};
  }

  // Polygonal data -----------------------------------------------------------------------------

  Result<void> addPolyData(const VtkPiece& piece) {
    const std::size_t first = builder_.pointCount();
    const std::uint64_t skipped = piece.vertices.count + piece.lines.count;
    const std::uint64_t cells = skipped + piece.polygons.count + piece.strips.count;
    if (auto added = addPoints(piece, cells); !added) return added;
    const auto ghosts = ghostsOf(piece, cells);
    if (!ghosts) return ghosts.error();
    // Data of cells are in this order.
    std::size_t row = skipped;
    for (const VtkCells* of : {&piece.polygons, &piece.strips}) {
      const auto read = cellsOf(*of, piece.points);
      if (!read) return read.error();
      for (std::size_t i = 0; i < of->count; ++i, ++row) {
        if (isLeftOut(*ghosts, row)) continue;
        const auto type = of == &piece.strips ? kVtkStrip : kVtkPolygon;
        if (auto added = addFace(type, read->at(i), first, rows_ + row); !added) return added;
      }
    }
    pointsAndLines_ += skipped;
    rows_ += cells;
    return {};
  }

  /// Adds a flat cell; `corners` are counted from the point `first`.
  Result<void> addFace(std::uint32_t type, std::span<const std::uint32_t> corners,
                       std::size_t first, std::size_t row) {
    corners_.clear();
    for (const std::uint32_t corner : corners) corners_.push_back(first + corner);
    builder_.setPart(static_cast<std::uint32_t>(row));
    if (type == kVtkStrip) return builder_.addStrip(corners_, row);
    if (type == kVtkPixel) std::swap(corners_[2], corners_[3]);
    return builder_.addPolygon(corners_, row);
  }

  // Unstructured grids -------------------------------------------------------------------------

  Result<SurfaceGrid> gridOf(const VtkPiece& piece) {
    const std::uint64_t count = piece.cells.count;
    SurfaceGrid grid;
    grid.firstPoint = builder_.pointCount();
    grid.firstRow = rows_;
    if (auto added = addPoints(piece, count); !added) return added.error();
    if (count == 0) return grid;
    const VtkArray* types = arrayNamed(piece.cells.arrays, "types");
    if (types == nullptr) return invalid("a piece has cells without types", path_);
    auto cells = cellsOf(piece.cells, piece.points);
    if (!cells) return cells.error();
    auto kinds = vtk_.types(*types, count);
    if (!kinds) return kinds.error();
    auto ghosts = ghostsOf(piece, count);
    if (!ghosts) return ghosts.error();
    grid.cells = std::move(*cells);
    grid.types = std::move(*kinds);
    grid.ghosts = std::move(*ghosts);
    rows_ += count;
    return grid;
  }

  /// Fails for cells that are not read, and for those with other numbers of corners than their
  /// types have; counts the others.
  Result<void> checkTypes(const SurfaceGrid& grid) {
    for (std::size_t i = 0; i < grid.types.size(); ++i) {
      const std::uint32_t type = grid.types[i];
      const auto wrong = [&](ErrorCode code, const std::string& what) {
        return fail(code, fmt::format("is a cell of VTK's type {}, {}", type, what),
                    placeOf(grid.firstRow + i));
      };
      if (isPointOrLine(type)) {
        ++pointsAndLines_;
        continue;
      }
      const VtkSolidShape* solid = vtkSolidShape(type);
      const auto flat = cornersOfFlat(type);
      if (solid == nullptr && !flat) {
        return wrong(ErrorCode::Unsupported,
                     "which is curved or not supported; ParaView's filter Extract Surface makes a "
                     "surface that can be saved as .vtp");
      }
      const std::size_t expected = solid != nullptr ? solid->corners : *flat;
      const std::size_t found = grid.cells.at(i).size();
      if (expected > 0 && found != expected) {
        return wrong(ErrorCode::InvalidInput,
                     fmt::format("with {} corners, expected {}", found, expected));
      }
      ++(solid != nullptr ? solids_ : flats_);
    }
    return {};
  }

  Result<void> addFlatCells(const std::vector<SurfaceGrid>& grids) {
    for (const SurfaceGrid& grid : grids) {
      for (std::size_t i = 0; i < grid.types.size(); ++i) {
        if (isPointOrLine(grid.types[i]) || isLeftOut(grid.ghosts, i)) continue;
        auto added = addFace(grid.types[i], grid.cells.at(i), grid.firstPoint, grid.firstRow + i);
        if (!added) return added;
      }
    }
    return {};
  }

  /// Adds the faces that only one cell has.
  Result<void> addBoundary(const std::vector<SurfaceGrid>& grids) {
    auto faces = facesOf(grids);
    std::ranges::sort(faces, {}, &Face::points);
    std::vector<Face> boundary;
    for (auto begin = faces.begin(); begin != faces.end();) {
      const auto end = std::find_if(begin, faces.end(),
                                    [&](const Face& face) { return face.points != begin->points; });
      if (end - begin == 1) boundary.push_back(*begin);
      if (end - begin > 2) {
        return invalid(fmt::format("has a face that it shares with {} other cells, expected one",
                                   end - begin - 1),
                       placeOf(grids[begin->grid].firstRow + begin->cell));
      }
      begin = end;
    }
    if (boundary.empty()) {
      return invalid(fmt::format("its {} volume cells have no boundary; for a 4D mesh, see t4d "
                                 "convert",
                                 solids_),
                     path_);
    }
    std::ranges::sort(boundary, {}, [](const Face& face) {
      return std::array{face.grid, face.cell, face.number};
    });
    for (const Face& face : boundary) {
      if (auto added = addFaceOfSolid(grids[face.grid], face); !added) return added;
    }
    return {};
  }

  std::vector<Face> facesOf(const std::vector<SurfaceGrid>& grids) const {
    const auto first = builder_.firstEquals();
    std::vector<Face> faces;
    for (std::uint32_t g = 0; g < grids.size(); ++g) {
      const SurfaceGrid& grid = grids[g];
      for (std::uint32_t i = 0; i < grid.types.size(); ++i) {
        const VtkSolidShape* shape = vtkSolidShape(grid.types[i]);
        if (shape == nullptr || isLeftOut(grid.ghosts, i)) continue;
        const auto corners = grid.cells.at(i);
        for (std::uint32_t k = 0; k < shape->faces.size(); ++k) {
          Face face{{model::kNoIndex, model::kNoIndex, model::kNoIndex, model::kNoIndex}, g, i, k};
          std::ranges::transform(shape->faces[k], face.points.begin(), [&](std::uint32_t corner) {
            return first[grid.firstPoint + corners[corner]];
          });
          if (makeKey(face.points)) faces.push_back(face);
        }
      }
    }
    return faces;
  }

  /// Sorts points and drops those that are there twice; false if fewer than three are left.
  static bool makeKey(std::array<std::uint32_t, 4>& points) {
    std::ranges::sort(points);
    const auto repeated = std::ranges::unique(points);
    std::ranges::fill(repeated, model::kNoIndex);
    return points[2] != model::kNoIndex;
  }

  Result<void> addFaceOfSolid(const SurfaceGrid& grid, const Face& face) {
    const VtkSolidShape& shape = *vtkSolidShape(grid.types[face.cell]);
    const auto corners = grid.cells.at(face.cell);
    std::vector<std::uint32_t> ofFace;
    for (const std::uint32_t corner : shape.faces[face.number]) ofFace.push_back(corners[corner]);
    if (isInsideOut(shape, corners, grid.firstPoint)) std::ranges::reverse(ofFace);
    return addFace(kVtkPolygon, ofFace, grid.firstPoint, grid.firstRow + face.cell);
  }

  /// Whether a cell has a negative volume: programs differ in the order of corners.
  bool isInsideOut(const VtkSolidShape& shape, std::span<const std::uint32_t> corners,
                   std::size_t first) const {
    const auto points = builder_.points();
    const model::Point3 origin = points[first + corners[0]];
    const auto from = [&](std::uint32_t corner) -> model::Point3 {
      return points[first + corners[corner]] - origin;
    };
    double volume = 0;
    for (const auto& face : shape.faces) {
      for (std::size_t i = 2; i < face.size(); ++i) {
        volume += from(face[0]).dot(from(face[i - 1]).cross(from(face[i])));
      }
    }
    return volume < 0;
  }

  // --------------------------------------------------------------------------------------------

  Result<LoadedMesh> finish() {
    for (const VtkArray& data : vtk_.fieldData()) {
      if (data.name != "TimeValue") data_.skip(data.name);
    }
    std::vector<model::Attribute> attributes = data_.take(builder_.pointCount(), rows_);
    std::set<std::string> lost = data_.skipped();
    if (keep_ == Keep::Shape) {
      for (const model::Attribute& attribute : attributes) {
        if (!looks_.contains(attribute.name)) lost.insert(attribute.name);
      }
      attributes.clear();
    }
    const auto has = [&](model::Domain domain) {
      return std::ranges::find(attributes, domain, &model::Attribute::domain) != attributes.end();
    };
    FileCorners corners;
    std::vector<std::uint32_t> rowOf;
    if (has(model::Domain::Vertex)) builder_.keepCornersIn(corners);
    if (has(model::Domain::Cell)) builder_.keepPartsIn(rowOf);
    auto loaded = std::move(builder_).finish();
    if (!loaded) return loaded;
    for (model::Attribute& attribute : attributes) {
      loaded->mesh.attributes.push_back(
          attribute.domain == model::Domain::Cell
              ? model::rowsOf(attribute, rowOf)
              : cornerAttribute(attribute, corners.points, corners, loaded->mesh));
      attribute.values = {};
    }
    if (solids_ > 0) {
      loaded->notices.push_back(
          fmt::format("the surface is the boundary of {} volume cells", solids_));
    }
    loaded->losses = lossesOf(lost);
    return loaded;
  }

  std::vector<std::string> lossesOf(const std::set<std::string>& data) const {
    std::vector<std::string> losses;
    if (pointsAndLines_ > 0) {
      losses.push_back(fmt::format("{} points and lines are not read", pointsAndLines_));
    }
    if (solids_ > 0 && flats_ > 0) {
      losses.push_back(fmt::format("{} faces beside the volume cells are not read", flats_));
    }
    if (!data.empty()) {
      losses.push_back(fmt::format("data that are not read: {}", fmt::join(data, ", ")));
    }
    return losses;
  }

  Keep keep_;
  std::string path_;
  VtkFile& vtk_;
  VtkData data_;
  MeshBuilder builder_;
  std::vector<std::uint64_t> corners_;  // of a face
  std::size_t rows_ = 0;                // of cell data
  std::uint64_t solids_ = 0;
  std::uint64_t flats_ = 0;
  std::uint64_t pointsAndLines_ = 0;
  /// Data that only say how a surface looks.
  std::set<std::string> looks_ = {"color"};
};

}  // namespace

Result<LoadedMesh> readVtp(const InputFile& file, Keep keep) {
  auto vtk = VtkFile::open(file, VtkType::PolyData);
  if (!vtk) return vtk.error();
  return VtkSurfaceReader(file, *vtk, keep).readPolyData();
}

Result<LoadedMesh> readVtuSurface(const InputFile& file, Keep keep) {
  auto vtk = VtkFile::open(file, VtkType::UnstructuredGrid);
  if (!vtk) return vtk.error();
  return VtkSurfaceReader(file, *vtk, keep).readGrid();
}

}  // namespace t4d::formats
