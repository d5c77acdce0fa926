#include "edit/outer_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <unordered_map>

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Object.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/intersections.h>
#include <fmt/format.h>

#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "model/parallel.h"
#include "model/surface_edges.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using ExactPoint = Exact::Point_3;
using model::Point3;
using model::Triangle;
using model::TriangleMesh;

/// A vertex of the triangulation of a plane: which of all vertices it is.
struct VertexId {
  std::uint32_t id = model::kNoIndex;
};

using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<VertexId, Exact>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Exact>;
using Planar = CGAL::Constrained_Delaunay_triangulation_2<
    Exact, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
    CGAL::Exact_intersections_tag>;

/// A piece of a triangle, or of several coplanar ones.
struct Piece {
  Triangle corners;
  int net = 1;  ///< triangles that it is part of, those that face the other way subtracted
  std::uint32_t group = 0;
};

/// The axis along which a plane can be projected: that of its largest normal component.
int axisOf(const Exact::Plane_3& plane) {
  const std::array<double, 3> normal = {std::abs(CGAL::to_double(plane.a())),
                                        std::abs(CGAL::to_double(plane.b())),
                                        std::abs(CGAL::to_double(plane.c()))};
  const auto largest = std::ranges::max_element(normal);
  if (std::isnormal(*largest)) return static_cast<int>(largest - normal.begin());
  // The normal of a tiny or huge triangle is beyond the range of doubles.
  const std::array exact = {CGAL::abs(plane.a()), CGAL::abs(plane.b()), CGAL::abs(plane.c())};
  return static_cast<int>(std::ranges::max_element(exact) - exact.begin());
}

Exact::Point_2 acrossAxis(const ExactPoint& p, int axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

/// Vertices with exact places, each once.
class ExactVertices {
 public:
  explicit ExactVertices(const TriangleMesh& mesh) : mesh_(mesh), points_(mesh.vertices.size()) {}

  /// A vertex of the input.
  const ExactPoint& ofInput(std::uint32_t vertex) {
    auto& point = points_[vertex];
    if (!point) {
      const Point3& p = mesh_.vertices[vertex];
      point.emplace(p.x(), p.y(), p.z());
      ids_.emplace(*point, vertex);
    }
    return *point;
  }

  std::uint32_t idOf(const ExactPoint& point) {
    const auto [at, isNew] = ids_.try_emplace(point, static_cast<std::uint32_t>(points_.size()));
    if (isNew) points_.emplace_back(point);
    return at->second;
  }

  const ExactPoint& operator[](std::uint32_t id) const { return *points_[id]; }

  /// The point of any vertex, also of an input vertex that nothing asked for before.
  ExactPoint at(std::uint32_t id) const {
    if (points_[id]) return *points_[id];
    const Point3& p = mesh_.vertices[id];
    return {p.x(), p.y(), p.z()};
  }

  std::vector<Point3> rounded() const {
    std::vector<Point3> result = mesh_.vertices;
    for (std::size_t i = result.size(); i < points_.size(); ++i) {
      const ExactPoint& p = *points_[i];
      result.emplace_back(CGAL::to_double(CGAL::exact(p.x())), CGAL::to_double(CGAL::exact(p.y())),
                          CGAL::to_double(CGAL::exact(p.z())));
    }
    return result;
  }

 private:
  const TriangleMesh& mesh_;
  std::vector<std::optional<ExactPoint>> points_;
  std::map<ExactPoint, std::uint32_t, Exact::Less_xyz_3> ids_;
};

/// Triangles in one plane that overlap, or one alone, with what meets them.
struct Group {
  std::vector<std::uint32_t> triangles;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> segments;  // vertices; equal for a point
};

class Arrangement {
 public:
  Arrangement(const TriangleMesh& mesh, const SurfaceCrossings& crossings)
      : mesh_(mesh), vertices_(mesh) {
    model::UnionFind planes(mesh.triangles.size());
    std::vector<bool> cut(mesh.triangles.size());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing;
    for (const auto& [a, b] : crossings.pairs) {
      for (const std::uint32_t triangle : {a, b}) {
        cut[triangle] = true;
        for (const std::uint32_t corner : mesh.triangles[triangle]) vertices_.ofInput(corner);
      }
      if (inOnePlane(a, b)) {
        planes.unite(a, b);
      } else {
        crossing.emplace_back(a, b);
      }
    }
    groupOf_.resize(mesh.triangles.size());
    std::vector<bool> flat(mesh.triangles.size());
    for (const std::uint32_t triangle : crossings.flat) flat[triangle] = true;
    std::unordered_map<std::uint32_t, std::uint32_t> groupOfRoot;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      if (flat[i]) continue;
      const auto [at, isNew] =
          groupOfRoot.try_emplace(planes.root(i), static_cast<std::uint32_t>(groups_.size()));
      if (isNew) groups_.emplace_back();
      groups_[at->second].triangles.push_back(i);
      groupOf_[i] = at->second;
      cutCount_ += cut[i] ? 1 : 0;
    }
    for (const auto& [a, b] : crossing) addCrossing(a, b);
    for (std::uint32_t group = 0; group < groups_.size(); ++group) {
      if (cut[groups_[group].triangles.front()]) {
        addPieces(group);
      } else {
        pieces_.push_back({mesh.triangles[groups_[group].triangles.front()], 1, group});
      }
    }
  }

  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<std::uint32_t>& trianglesOf(const Piece& piece) const {
    return groups_[piece.group].triangles;
  }
  std::vector<Point3> places() const { return vertices_.rounded(); }
  ExactPoint exactPlace(std::uint32_t vertex) const { return vertices_.at(vertex); }
  std::uint64_t cutCount() const { return cutCount_; }

 private:
  Exact::Triangle_3 exactTriangle(std::uint32_t triangle) {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    return {vertices_.ofInput(a), vertices_.ofInput(b), vertices_.ofInput(c)};
  }

  bool inOnePlane(std::uint32_t first, std::uint32_t second) {
    const Exact::Triangle_3 a = exactTriangle(first);
    return std::ranges::all_of(mesh_.triangles[second], [&](std::uint32_t corner) {
      return CGAL::coplanar(a[0], a[1], a[2], vertices_.ofInput(corner));
    });
  }

  /// Adds the segment where two triangles of different planes meet as a constraint of both.
  void addCrossing(std::uint32_t a, std::uint32_t b) {
    // An Object is made of the variants of all versions of CGAL.
    const CGAL::Object common = CGAL::intersection(exactTriangle(a), exactTriangle(b));
    std::pair<std::uint32_t, std::uint32_t> segment;
    if (const auto* point = CGAL::object_cast<ExactPoint>(&common)) {
      segment.first = segment.second = vertices_.idOf(*point);
    } else if (const auto* line = CGAL::object_cast<Exact::Segment_3>(&common)) {
      segment.first = vertices_.idOf(line->source());
      segment.second = vertices_.idOf(line->target());
    } else {
      return;  // triangles in different planes meet in nothing else
    }
    groups_[groupOf_[a]].segments.push_back(segment);
    groups_[groupOf_[b]].segments.push_back(segment);
  }

  void addPieces(std::uint32_t index) {
    const Group& group = groups_[index];
    const Exact::Triangle_3 first = exactTriangle(group.triangles.front());
    const Exact::Plane_3 plane(first[0], first[1], first[2]);
    const int axis = axisOf(plane);
    const auto flattened = [&](const ExactPoint& p) { return acrossAxis(p, axis); };
    Planar planar;
    std::unordered_map<std::uint32_t, Planar::Vertex_handle> handles;
    const auto handleOf = [&](std::uint32_t id) {
      auto& handle = handles[id];
      if (handle == Planar::Vertex_handle()) {
        handle = planar.insert(flattened(vertices_[id]));
        handle->info().id = id;
      }
      return handle;
    };
    // All points first: a constraint that is inserted later is then split at them by their
    // vertices.
    for (const std::uint32_t triangle : group.triangles) {
      for (const std::uint32_t corner : mesh_.triangles[triangle]) handleOf(corner);
    }
    for (const auto& [from, to] : group.segments) {
      handleOf(from);
      handleOf(to);
    }
    for (const std::uint32_t triangle : group.triangles) {
      const auto& [a, b, c] = mesh_.triangles[triangle];
      planar.insert_constraint(handleOf(a), handleOf(b));
      planar.insert_constraint(handleOf(b), handleOf(c));
      planar.insert_constraint(handleOf(c), handleOf(a));
    }
    for (const auto& [from, to] : group.segments) {
      if (from != to) planar.insert_constraint(handleOf(from), handleOf(to));
    }

    struct Flattened {
      std::array<Exact::Point_2, 3> corners;  // counter-clockwise
      CGAL::Bbox_2 box;
      int sign;
    };
    std::vector<Flattened> triangles;
    for (const std::uint32_t triangle : group.triangles) {
      const Exact::Triangle_3 t = exactTriangle(triangle);
      std::array<Exact::Point_2, 3> corners = {flattened(t[0]), flattened(t[1]), flattened(t[2])};
      const int sign =
          CGAL::orientation(corners[0], corners[1], corners[2]) == CGAL::LEFT_TURN ? 1 : -1;
      if (sign < 0) std::swap(corners[1], corners[2]);
      triangles.push_back(
          {corners, corners[0].bbox() + corners[1].bbox() + corners[2].bbox(), sign});
    }

    const auto lifted = [&](const Exact::Point_2& p) {
      const std::array<Exact::FT, 4> n = {plane.a(), plane.b(), plane.c(), plane.d()};
      std::array<Exact::FT, 3> at;
      at[(axis + 1) % 3] = p.x();
      at[(axis + 2) % 3] = p.y();
      at[axis] = -(n[(axis + 1) % 3] * p.x() + n[(axis + 2) % 3] * p.y() + n[3]) / n[axis];
      return ExactPoint(at[0], at[1], at[2]);
    };
    for (auto face = planar.finite_faces_begin(); face != planar.finite_faces_end(); ++face) {
      Piece piece;
      piece.group = index;
      piece.net = 0;
      const Exact::Point_2 middle = CGAL::centroid(
          face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point());
      const CGAL::Bbox_2 box = middle.bbox();
      for (const auto& [corners, bounds, sign] : triangles) {
        if (!CGAL::do_overlap(box, bounds)) continue;
        bool inside = true;
        for (int i = 0; i < 3 && inside; ++i) {
          inside = CGAL::orientation(corners[i], corners[(i + 1) % 3], middle) == CGAL::LEFT_TURN;
        }
        if (inside) piece.net += sign;
      }
      if (piece.net == 0) continue;
      for (int i = 0; i < 3; ++i) {
        const auto vertex = face->vertex(i);
        if (vertex->info().id == model::kNoIndex)
          vertex->info().id = vertices_.idOf(lifted(vertex->point()));
        piece.corners[i] = vertex->info().id;
      }
      pieces_.push_back(piece);
    }
  }

  const TriangleMesh& mesh_;
  ExactVertices vertices_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> groupOf_;
  std::vector<Piece> pieces_;
  std::uint64_t cutCount_ = 0;
};

/// Pieces connected across edges that only two have: on each side of a patch the winding number is
/// the same everywhere.
model::UnionFind patchesOf(const std::vector<Piece>& pieces) {
  std::vector<Triangle> triangles;
  triangles.reserve(pieces.size());
  for (const Piece& piece : pieces) triangles.push_back(piece.corners);
  const model::SurfaceEdges edges = model::edgesOf(triangles);
  model::UnionFind patches(pieces.size());
  for (const model::EdgeSides& edge : edges.edges) {
    // A piece may be there for several triangles, or stand for the opposite orientation.
    if (edge.end - edge.begin != 2) continue;
    patches.unite(edges.sides[edge.begin] / 3, edges.sides[edge.begin + 1] / 3);
  }
  return patches;
}

/// The winding number behind a piece, the side that its corners are clockwise seen from.
class Classifier {
 public:
  Classifier(const TriangleMesh& mesh, const Arrangement& arrangement, std::vector<Point3> places)
      : mesh_(mesh),
        arrangement_(arrangement),
        places_(std::move(places)),
        winding_(mesh),
        tree_(mesh) {}

  double areaOf(const Piece& piece) const {
    const auto& [a, b, c] = piece.corners;
    return (places_[b] - places_[a]).cross(places_[c] - places_[a]).norm();
  }

  /// The winding number behind a piece. Nothing if the computed value is not close enough to an
  /// integer: the piece is too small, or too close to another.
  std::optional<int> behind(const Piece& piece) const {
    const auto& [a, b, c] = piece.corners;
    const Point3 middle = (places_[a] + places_[b] + places_[c]) / 3;
    // Triangles in the plane of the piece count as nothing. Those that contain its middle are too
    // near for `at` to replace them by a dipole.
    double own = 0;
    for (const std::uint32_t triangle : arrangement_.trianglesOf(piece)) {
      const auto& [p, q, r] = mesh_.triangles[triangle];
      own += measure::WindingNumber::ofTriangle(
          {mesh_.vertices[p], mesh_.vertices[q], mesh_.vertices[r]}, middle);
    }
    const double mean = winding_.at(middle) - own;
    const double behind = mean + 0.5 * piece.net;
    constexpr double kSure = 0.2;
    const double whole = std::round(behind);
    if (!(std::abs(behind - whole) < kSure)) return std::nullopt;
    return static_cast<int>(whole);
  }

  /// Like `behind`, in exact arithmetic, for pieces thinner than rounding: counts the triangles
  /// that a line from within the piece meets. Nothing if all lines that are tried touch an edge.
  std::optional<int> exactlyBehind(const Piece& piece) const {
    std::array<ExactPoint, 3> corners;
    for (int i = 0; i < 3; ++i) corners[i] = arrangement_.exactPlace(piece.corners[i]);
    const Exact::Plane_3 plane(corners[0], corners[1], corners[2]);
    if (plane.is_degenerate()) return std::nullopt;
    const int axis = axisOf(plane);
    const bool facesUp =
        CGAL::orientation(acrossAxis(corners[0], axis), acrossAxis(corners[1], axis),
                          acrossAxis(corners[2], axis)) == CGAL::LEFT_TURN;
    for (const std::array<int, 3>& weights : {std::array{1, 1, 1}, {31, 17, 23}, {7, 41, 29}}) {
      const ExactPoint from =
          CGAL::barycenter(corners[0], Exact::FT(weights[0]), corners[1], Exact::FT(weights[1]),
                           corners[2], Exact::FT(weights[2]));
      const std::optional<int> above = windingAbove(from, axis, piece);
      if (above) return facesUp ? *above + piece.net : *above;
    }
    return std::nullopt;
  }

  const std::vector<Point3>& places() const { return places_; }

 private:
  /// The winding number of all triangles but those in the plane of the piece on the upper side.
  std::optional<int> windingAbove(const ExactPoint& from, int axis, const Piece& piece) const {
    const Exact::Point_2 line = acrossAxis(from, axis);
    const CGAL::Bbox_2 around = line.bbox();
    model::Bounds3 box;
    box.min[axis] = -HUGE_VAL;
    box.max[axis] = HUGE_VAL;
    for (int k = 0; k < 2; ++k) {
      box.min[(axis + 1 + k) % 3] = around.min(k);
      box.max[(axis + 1 + k) % 3] = around.max(k);
    }
    const auto& own = arrangement_.trianglesOf(piece);
    int winding = 0;
    bool touches = false;
    tree_.forEachReaching(box, [&](std::uint32_t i) {
      if (touches || std::ranges::find(own, i) != own.end()) return;
      const std::optional<int> met = metBy(line, from, axis, i);
      touches = !met;
      winding += met.value_or(0);
    });
    if (touches) return std::nullopt;
    return winding;
  }

  /// What a triangle that a line meets above a point adds to its winding number. Nothing if it
  /// meets the border, or the point is on the triangle.
  std::optional<int> metBy(const Exact::Point_2& line, const ExactPoint& from, int axis,
                           std::uint32_t triangle) const {
    std::array<ExactPoint, 3> corners;
    for (int k = 0; k < 3; ++k) corners[k] = arrangement_.exactPlace(mesh_.triangles[triangle][k]);
    std::array<int, 3> sides;
    for (int k = 0; k < 3; ++k) {
      sides[k] = static_cast<int>(CGAL::orientation(acrossAxis(corners[k], axis),
                                                    acrossAxis(corners[(k + 1) % 3], axis), line));
    }
    const auto [least, most] = std::ranges::minmax(sides);
    if (least < 0 && most > 0) return 0;
    if (least * most == 0) return std::nullopt;
    const int side = static_cast<int>(CGAL::orientation(corners[0], corners[1], corners[2], from));
    if (side == 0) return std::nullopt;
    return side == least ? 0 : least;
  }

  const TriangleMesh& mesh_;
  const Arrangement& arrangement_;
  std::vector<Point3> places_;
  measure::WindingNumber winding_;
  measure::TriangleTree tree_;
};

Result<OuterSurface> outerOf(const TriangleMesh& mesh, const SurfaceCrossings& crossings) {
  const Arrangement arrangement(mesh, crossings);
  const auto& pieces = arrangement.pieces();
  const Classifier classifier(mesh, arrangement, arrangement.places());
  model::UnionFind patches = patchesOf(pieces);
  // The largest pieces of each patch, which decide for all of it.
  constexpr std::size_t kAsked = 4;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> largest;
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    auto& asked = largest[patches.root(i)];
    asked.push_back(i);
    if (asked.size() <= 4 * kAsked) continue;
    std::ranges::nth_element(asked, asked.begin() + kAsked, std::greater(),
                             [&](std::uint32_t p) { return classifier.areaOf(pieces[p]); });
    asked.resize(kAsked);
  }
  struct Sides {
    int behind;
    std::uint32_t piece;
  };
  std::vector<std::uint32_t> roots;
  for (const auto& [patch, asked] : largest) roots.push_back(patch);
  std::vector<std::optional<Sides>> known(roots.size());
  model::forEach(roots.size(), [&](std::size_t i) {
    auto& asked = largest.find(roots[i])->second;
    std::ranges::sort(asked, std::greater(),
                      [&](std::uint32_t p) { return classifier.areaOf(pieces[p]); });
    for (const std::uint32_t piece : asked) {
      if (known[i]) return;
      if (const auto behind = classifier.behind(pieces[piece])) known[i] = Sides{*behind, piece};
    }
  });
  // Exact numbers are not for several threads.
  std::unordered_map<std::uint32_t, Sides> sides;
  for (std::size_t i = 0; i < roots.size(); ++i) {
    for (const std::uint32_t piece : largest.find(roots[i])->second) {
      if (known[i]) break;
      if (const auto behind = classifier.exactlyBehind(pieces[piece])) {
        known[i] = Sides{*behind, piece};
      }
    }
    if (known[i]) sides.emplace(roots[i], *known[i]);
  }

  // Within a patch pieces may face either way, with a negative number then: what counts is the way
  // in which its triangles face, and there the numbers are the same.
  const auto facing = [&](std::uint32_t piece) { return pieces[piece].net > 0; };
  OuterSurface result;
  result.cut = arrangement.cutCount();
  result.mesh.vertices = classifier.places();
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    const auto found = sides.find(patches.root(i));
    if (found == sides.end()) {
      return fail(ErrorCode::Unsupported,
                  "surfaces lie so close to each other that it cannot be told which is the outer "
                  "one",
                  {}, Remedy::Remesh);
    }
    const auto& [behindOfAsked, asked] = found->second;
    // The sides of the piece that was asked, in terms of how the triangles face.
    const int net = std::abs(pieces[asked].net);
    const int back = facing(asked) ? behindOfAsked : behindOfAsked - pieces[asked].net;
    const bool solidBehind = back >= 1;
    const bool solidInFront = back - net >= 1;
    if (solidBehind == solidInFront) {
      ++result.dropped;
      continue;
    }
    Triangle corners = pieces[i].corners;
    if (facing(i) != solidBehind) std::swap(corners[1], corners[2]);
    result.mesh.triangles.push_back(corners);
  }
  return result;
}

}  // namespace

Result<OuterSurface> outerSurface(const TriangleMesh& mesh, const SurfaceCrossings& crossings) try {
  return outerOf(mesh, crossings);
} catch (const std::exception& error) {
  return fail(ErrorCode::Failed,
              fmt::format("cutting the triangles that cross failed: {}", error.what()), {},
              Remedy::Remesh);
}

}  // namespace t4d::edit
