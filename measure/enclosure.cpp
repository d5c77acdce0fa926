#include "measure/enclosure.h"

#include <algorithm>
#include <atomic>

#include "measure/surface_genus.h"
#include "measure/winding_number.h"
#include "model/parallel.h"

namespace t4d::measure {
namespace {

using model::TriangleMesh;
using Corners = std::array<model::Point3, 3>;

/// Calls visit(piece) for pieces of a triangle without an edge longer than `longestOf(piece)`.
template <class LongestOf, class Visit>
void forEachPiece(const Corners& triangle, const LongestOf& longestOf, const Visit& visit) {
  std::vector<Corners> left = {triangle};
  while (!left.empty()) {
    const Corners piece = left.back();
    left.pop_back();
    const auto edge = [&](std::size_t k) { return (piece[(k + 1) % 3] - piece[k]).norm(); };
    std::size_t longest = 0;
    for (const std::size_t k : {1U, 2U}) {
      if (edge(k) > edge(longest)) longest = k;
    }
    const model::Point3& a = piece[longest];
    const model::Point3& b = piece[(longest + 1) % 3];
    const model::Point3 middle = (a + b) / 2;
    // Coordinates may be too coarse to halve an edge.
    if (!(edge(longest) > longestOf(piece)) || middle == a || middle == b) {
      visit(piece);
      continue;
    }
    const model::Point3& opposite = piece[(longest + 2) % 3];
    left.push_back({a, middle, opposite});
    left.push_back({middle, b, opposite});
  }
}

/// Whether all connected parts of one surface have a winding number in another, which they do not
/// meet, that is as it should be.
template <class IsRight>
bool allParts(const TriangleMesh& parts, const TriangleMesh& other, const IsRight& isRight) {
  return std::ranges::all_of(surfacesOf(parts), [&](const ConnectedSurface& part) {
    return isRight(WindingNumber::exactAt(other, parts.vertices[part.vertex]));
  });
}

}  // namespace

EnclosedPlaces::EnclosedPlaces(const TriangleMesh& surface) : surface_(surface), tree_(surface) {
  constexpr double kPieces = 64;  // along the diagonal
  bounds_ = model::boundsOf(surface);
  pieceLength_ = (bounds_.max - bounds_.min).norm() / kPieces;
}

/// Pieces that are far away may be as long as their distance: they are not many, however large the
/// mesh.
double EnclosedPlaces::longestPiece(const std::array<model::Point3, 3>& piece) const {
  model::Bounds3 box;
  for (const model::Point3& corner : piece) box.add(corner);
  const double away = (box.min - bounds_.max).cwiseMax(bounds_.min - box.max).cwiseMax(0).norm();
  return std::max(pieceLength_, away);
}

double EnclosedPlaces::leastDistance(const TriangleMesh& mesh, double enough) const {
  std::atomic<double> least = enough;
  model::forEach(mesh.triangles.size(), [&](std::size_t i) {
    const auto& [a, b, c] = mesh.triangles[i];
    forEachPiece(
        {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]},
        [&](const Corners& piece) { return longestPiece(piece); },
        [&](const Corners& piece) {
          double known = least.load(std::memory_order_relaxed);
          const double found = tree_.distanceFrom(piece, known);
          while (found < known && !least.compare_exchange_weak(known, found)) {
          }
        });
  });
  return least;
}

double EnclosedPlaces::margin(const TriangleMesh& mesh, double enough) const {
  const double least = leastDistance(mesh, enough);
  if (!(least > 0)) return 0;
  const bool encloses = allParts(mesh, surface_, [](double number) { return number < 0.5; }) &&
                        allParts(surface_, mesh, [](double number) { return number > 0.5; });
  return encloses ? least : 0;
}

}  // namespace t4d::measure
