#include "formats/mesh4d/polyhedra.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "formats/mesh4d/polyhedron.h"
#include "model/facets.h"

namespace t4d::formats {
namespace {

using model::Cell;
using model::Point4;

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

/// Whether a triangle has more than two tetrahedra.
bool haveTrianglesTwice(std::vector<Cell>& tetrahedra, std::size_t vertexCount) {
  model::Connectivity connectivity;
  connectivity.vertexCount = static_cast<std::uint32_t>(vertexCount);
  connectivity.cells = std::move(tetrahedra);
  const model::FacetParts parts(connectivity);
  bool found = false;
  for (std::size_t i = 0; i < parts.size() && !found; ++i) {
    found = std::ranges::any_of(parts.topology(i).unmatched, [](const model::Facet& facet) {
      return facet.even + facet.odd > 2;
    });
  }
  tetrahedra = std::move(connectivity.cells);
  return found;
}

Result<void> addCentre(std::span<const std::uint32_t> corners, Mesh4dBuilder& mesh) {
  Point4 sum = Point4::Zero();
  for (const std::uint32_t corner : corners) sum += mesh.vertices()[corner];
  return mesh.addVertex(sum / static_cast<double>(corners.size()), mesh.vertexCount());
}

}  // namespace

void Polyhedra::addFace(std::span<const std::uint32_t> corners) {
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  faceBegin_.push_back(corners_.size());
}

void Polyhedra::addCell(std::span<const std::uint32_t> faces) {
  faces_.insert(faces_.end(), faces.begin(), faces.end());
  cellBegin_.push_back(faces_.size());
}

std::span<const std::uint32_t> Polyhedra::face(std::size_t i) const {
  return std::span(corners_).subspan(faceBegin_[i], faceBegin_[i + 1] - faceBegin_[i]);
}

std::span<const std::uint32_t> Polyhedra::cell(std::size_t i) const {
  return std::span(faces_).subspan(cellBegin_[i], cellBegin_[i + 1] - cellBegin_[i]);
}

/// Returns how many cells are no tetrahedra.
std::size_t Polyhedra::pull(std::vector<Cell>& tetrahedra) const {
  const auto take = [&](const Cell& tetrahedron) { tetrahedra.push_back(tetrahedron); };
  std::size_t polyhedra = 0;
  std::vector<std::span<const std::uint32_t>> ofCell;
  for (std::size_t i = 0; i < cellCount(); ++i) {
    ofCell.clear();
    for (const std::uint32_t number : cell(i)) ofCell.push_back(face(number));
    if (const auto tetrahedron = tetrahedronOf(ofCell)) {
      take(*tetrahedron);
    } else {
      ++polyhedra;
      pullPolyhedron(ofCell, take);
    }
  }
  return polyhedra;
}

Result<std::vector<Cell>> Polyhedra::splitFromCentres(Mesh4dBuilder& mesh) const {
  const auto firstOfFaces = static_cast<std::uint32_t>(mesh.vertexCount());
  for (std::size_t i = 0; i < faceCount(); ++i) {
    if (auto added = addCentre(face(i), mesh); !added) return added.error();
  }
  std::vector<Cell> tetrahedra;
  std::vector<std::uint32_t> centres;
  for (std::size_t i = 0; i < cellCount(); ++i) {
    centres.assign(cell(i).begin(), cell(i).end());
    for (std::uint32_t& centre : centres) centre += firstOfFaces;
    const auto apex = static_cast<std::uint32_t>(mesh.vertexCount());
    if (auto added = addCentre(centres, mesh); !added) return added.error();
    for (const std::uint32_t number : cell(i)) {
      const auto corners = face(number);
      for (std::size_t k = 0; k < corners.size(); ++k) {
        const std::uint32_t next = corners[(k + 1) % corners.size()];
        tetrahedra.push_back({apex, firstOfFaces + number, corners[k], next});
      }
    }
  }
  return tetrahedra;
}

Result<std::string> Polyhedra::addTo(Mesh4dBuilder& mesh) const {
  std::vector<Cell> tetrahedra;
  std::string notice;
  if (const std::size_t polyhedra = pull(tetrahedra); polyhedra > 0) {
    notice = fmt::format("{} polyhedral cells are split into tetrahedra", polyhedra);
    if (haveTrianglesTwice(tetrahedra, mesh.vertexCount())) {
      notice += " from their centres, since some cross others";
      auto split = splitFromCentres(mesh);
      if (!split) return split.error();
      tetrahedra = std::move(*split);
    }
  }
  if (auto added = mesh.addCells(std::move(tetrahedra), 0, {}); !added) return added.error();
  return notice;
}

}  // namespace t4d::formats
