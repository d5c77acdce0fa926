#include "edit/carried_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "measure/triangle_tree.h"
#include "model/attribute_rows.h"
#include "model/corner_attributes.h"
#include "model/parallel.h"
#include "model/unit_scale.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Domain;
using model::Point3;
using model::ScalarType;
using model::Triangle;
using model::TriangleMesh;

/// A point of a triangle of `before`.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> weights = {1, 0, 0};  ///< of its corners; never negative

  bool isCorner() const { return std::ranges::max(weights) == 1; }
  std::uint32_t nearestCorner() const {
    return static_cast<std::uint32_t>(std::ranges::max_element(weights) - weights.begin());
  }
};

SurfacePoint atCorner(std::uint32_t triangle, std::size_t corner) {
  SurfacePoint place{triangle, {0, 0, 0}};
  place.weights[corner] = 1;
  return place;
}

Triangle sortedCorners(Triangle triangle) {
  std::ranges::sort(triangle);
  return triangle;
}

/// Whether two triangles with the same corners face the same side.
bool facesAlike(const Triangle& a, const Triangle& b) {
  const auto at = std::ranges::find(b, a[0]) - b.begin();
  return b[(at + 1) % 3] == a[1];
}

/// The triangles of `before`, by their corners, edges and vertices.
class KnownTriangles {
 public:
  explicit KnownTriangles(std::span<const Triangle> triangles) : triangles_(triangles) {
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      all_.emplace_back(sortedCorners(triangles[i]), i);
      for (std::uint32_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax({triangles[i][k], triangles[i][(k + 1) % 3]});
        edges_.emplace_back(std::array{low, high}, i);
        corners_.emplace_back(triangles[i][k], 3 * i + k);
      }
    }
    std::ranges::sort(all_);
    std::ranges::sort(edges_);
    std::ranges::sort(corners_);
  }

  /// The triangle with these corners, if possible one that faces the same side.
  std::optional<std::uint32_t> withCorners(const Triangle& corners) const {
    const auto found = std::ranges::equal_range(all_, sortedCorners(corners), {},
                                                [](const auto& one) { return one.first; });
    if (found.empty()) return std::nullopt;
    for (const auto& [key, triangle] : found) {
      if (facesAlike(corners, triangles_[triangle])) return triangle;
    }
    return found.front().second;
  }

  std::optional<std::uint32_t> withEdge(std::uint32_t from, std::uint32_t to) const {
    const auto [low, high] = std::minmax({from, to});
    return first(edges_, std::array{low, high});
  }

  /// A corner at a vertex, as 3 * triangle + number; every vertex has one.
  std::uint32_t cornerAt(std::uint32_t vertex) const { return *first(corners_, vertex); }

 private:
  template <class Key>
  static std::optional<std::uint32_t> first(const std::vector<std::pair<Key, std::uint32_t>>& list,
                                            const Key& key) {
    const auto found =
        std::ranges::lower_bound(list, key, {}, [](const auto& one) { return one.first; });
    if (found == list.end() || found->first != key) return std::nullopt;
    return found->second;
  }

  std::span<const Triangle> triangles_;
  std::vector<std::pair<Triangle, std::uint32_t>> all_;
  std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> edges_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> corners_;
};

/// The triangles of `before` in space.
class PlacedTriangles {
 public:
  explicit PlacedTriangles(const TriangleMesh& mesh)
      : scale_(model::UnitScale::of({&mesh})), mesh_(scale_.toUnit(mesh)), tree_(mesh_) {
    const model::Bounds3 bounds = boundsOf(mesh_);
    // More than what cutting rounds new vertices by.
    constexpr double kOfDiagonal = 1e-9;
    rounding_ = kOfDiagonal * (bounds.max - bounds.min).norm();
  }

  std::uint32_t nearestTo(const Point3& point) const {
    return tree_.nearest(scale_.toUnit(point)).triangle;
  }

  /// The triangle that another one is a piece of: of those that its middle is on, the one that is
  /// most parallel to it.
  std::optional<std::uint32_t> around(std::array<Point3, 3> piece) const {
    for (Point3& corner : piece) corner = scale_.toUnit(corner);
    const Point3 middle = (piece[0] + piece[1] + piece[2]) / 3;
    const Point3 normal = (piece[1] - piece[0]).cross(piece[2] - piece[0]).stableNormalized();
    model::Bounds3 box;
    box.add(middle - Point3::Constant(rounding_));
    box.add(middle + Point3::Constant(rounding_));
    std::optional<std::uint32_t> best;
    double most = -1;
    tree_.forEachReaching(box, [&](std::uint32_t triangle) {
      if (tree_.distanceTo(triangle, middle) > rounding_) return;
      const double parallel = std::abs(normal.dot(normalOf(triangle)));
      if (parallel < most || (parallel == most && triangle > *best)) return;
      best = triangle;
      most = parallel;
    });
    return best;
  }

  /// The point of a triangle nearest to another point, as good as weights of its corners can say.
  SurfacePoint nearestIn(std::uint32_t triangle, const Point3& given) const {
    const Point3 point = scale_.toUnit(given);
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const std::array corners = {mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]};
    const Point3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double area = normal.squaredNorm();
    SurfacePoint place{triangle};
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3 along = corners[(k + 2) % 3] - corners[(k + 1) % 3];
      const double weight = along.cross(point - corners[(k + 1) % 3]).dot(normal) / area;
      // Rounding would keep corners and edges from having the values of their ends alone.
      constexpr double kRounding = 1e-9;
      place.weights[k] = weight > kRounding ? weight : 0;
      sum += place.weights[k];
    }
    if (sum > 0 && std::isfinite(sum)) {
      for (double& weight : place.weights) weight /= sum;
      return place;
    }
    const auto nearest = std::ranges::min_element(
        corners, {}, [&](const Point3& corner) { return (corner - point).squaredNorm(); });
    return atCorner(triangle, static_cast<std::size_t>(nearest - corners.begin()));
  }

 private:
  Point3 normalOf(std::uint32_t triangle) const {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const Point3& p = mesh_.vertices[a];
    return (mesh_.vertices[b] - p).cross(mesh_.vertices[c] - p).stableNormalized();
  }

  model::UnitScale scale_;
  TriangleMesh mesh_;  // in the unit of the scale, as all that follows
  measure::TriangleTree tree_;
  double rounding_ = 0;
};

/// The origins of the triangles of `after` and of their corners.
struct Descent {
  std::vector<std::uint32_t> triangles;
  std::vector<SurfacePoint> corners;  ///< three for each triangle
};

class Tracer {
 public:
  Tracer(const TriangleMesh& before, std::span<const Triangle> merged, const TriangleMesh& after,
         std::span<const VertexOrigin> origins)
      : before_(before), merged_(merged), after_(after), origins_(origins), known_(merged) {}

  Descent trace() {
    Descent descent;
    descent.triangles.resize(after_.triangles.size());
    descent.corners.resize(3 * after_.triangles.size());
    std::vector<std::uint32_t> others;
    for (std::uint32_t i = 0; i < after_.triangles.size(); ++i) {
      if (origins_.empty() || !traceByVertices(i, descent)) others.push_back(i);
    }
    if (others.empty()) return descent;
    const PlacedTriangles placed(before_);
    model::forEach(others.size(), [&](std::size_t i) {
      if (origins_.empty()) {
        traceNearest(others[i], placed, descent);
      } else if (!tracePiece(others[i], placed, descent)) {
        traceFilling(others[i], descent);
      }
    });
    return descent;
  }

 private:
  /// A corner of `after`, if it is one of a triangle of `before`, or in the middle of two.
  std::optional<SurfacePoint> placeIn(std::uint32_t triangle, const VertexOrigin& origin) const {
    SurfacePoint place{triangle, {0, 0, 0}};
    for (const std::uint32_t vertex : origin) {
      const auto at = std::ranges::find(merged_[triangle], vertex);
      if (at == merged_[triangle].end()) return std::nullopt;
      place.weights[static_cast<std::size_t>(at - merged_[triangle].begin())] += 0.5;
    }
    return place;
  }

  std::array<Point3, 3> placesOf(std::uint32_t triangle) const {
    const auto& [a, b, c] = after_.triangles[triangle];
    return {after_.vertices[a], after_.vertices[b], after_.vertices[c]};
  }

  const VertexOrigin& originOf(std::uint32_t triangle, std::size_t corner) const {
    return origins_[after_.triangles[triangle][corner]];
  }

  /// One with the same corners, or divided at the middles of its edges.
  bool traceByVertices(std::uint32_t triangle, Descent& descent) const {
    std::vector<std::uint32_t> vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      for (const std::uint32_t vertex : originOf(triangle, k)) {
        if (vertex == model::kNoIndex) return false;
        if (std::ranges::find(vertices, vertex) == vertices.end()) vertices.push_back(vertex);
      }
    }
    if (vertices.size() != 3) return false;
    const auto from = known_.withCorners({vertices[0], vertices[1], vertices[2]});
    if (!from) return false;
    descent.triangles[triangle] = *from;
    for (std::size_t k = 0; k < 3; ++k) {
      descent.corners[3 * triangle + k] = *placeIn(*from, originOf(triangle, k));
    }
    return true;
  }

  bool tracePiece(std::uint32_t triangle, const PlacedTriangles& placed, Descent& descent) const {
    const auto places = placesOf(triangle);
    const bool isNew = std::ranges::any_of(after_.triangles[triangle], [&](std::uint32_t corner) {
      return origins_[corner] == kNewVertex;
    });
    std::optional<std::uint32_t> from = placed.around(places);
    if (!from && !isNew) return false;
    if (!from) from = placed.nearestTo((places[0] + places[1] + places[2]) / 3);
    descent.triangles[triangle] = *from;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto known = placeIn(*from, originOf(triangle, k));
      descent.corners[3 * triangle + k] = known ? *known : placed.nearestIn(*from, places[k]);
    }
    return true;
  }

  /// Traces a triangle that is between vertices of `before`, and away from its triangles.
  void traceFilling(std::uint32_t triangle, Descent& descent) const {
    std::optional<std::uint32_t> from;
    for (std::size_t k = 0; k < 3 && !from; ++k) {
      from = known_.withEdge(originOf(triangle, k)[0], originOf(triangle, (k + 1) % 3)[0]);
    }
    if (!from) from = known_.cornerAt(originOf(triangle, 0)[0]) / 3;
    descent.triangles[triangle] = *from;
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexOrigin& origin = originOf(triangle, k);
      std::optional<SurfacePoint> place = placeIn(*from, origin);
      if (!place && origin[0] != origin[1]) {
        if (const auto beside = known_.withEdge(origin[0], origin[1])) {
          place = placeIn(*beside, origin);
        }
      }
      if (!place) {
        const std::uint32_t corner = known_.cornerAt(origin[0]);
        place = atCorner(corner / 3, corner % 3);
      }
      descent.corners[3 * triangle + k] = *place;
    }
  }

  void traceNearest(std::uint32_t triangle, const PlacedTriangles& placed, Descent& descent) const {
    const auto places = placesOf(triangle);
    const std::uint32_t from = placed.nearestTo((places[0] + places[1] + places[2]) / 3);
    descent.triangles[triangle] = from;
    for (std::size_t k = 0; k < 3; ++k) {
      descent.corners[3 * triangle + k] = placed.nearestIn(from, places[k]);
    }
  }

  const TriangleMesh& before_;
  std::span<const Triangle> merged_;
  const TriangleMesh& after_;
  std::span<const VertexOrigin> origins_;
  KnownTriangles known_;
};

/// The vertices of `after` on the surface `before`, each for itself.
std::vector<SurfacePoint> nearestPlaces(const TriangleMesh& before, const TriangleMesh& after) {
  const PlacedTriangles placed(before);
  std::vector<SurfacePoint> places(after.vertices.size());
  model::forEach(places.size(), [&](std::size_t i) {
    places[i] = placed.nearestIn(placed.nearestTo(after.vertices[i]), after.vertices[i]);
  });
  return places;
}

template <class Number>
Number numberAt(const std::byte* row, std::size_t index) {
  Number number;
  std::memcpy(&number, row + index * sizeof(Number), sizeof(Number));
  return number;
}

/// Values at the corners of `before`, by a vertex attribute or one of corners.
class CornerValues {
 public:
  CornerValues(const Attribute& attribute, const TriangleMesh& before)
      : attribute_(attribute),
        before_(before),
        ofVertices_(attribute.domain == Domain::Vertex),
        components_(ofVertices_ ? attribute.components : attribute.components / 3),
        bytes_(scalarSize(attribute.type) * components_) {
    if (attribute.type == ScalarType::Float32) findLargest<float>();
    if (attribute.type == ScalarType::Float64) findLargest<double>();
  }

  std::size_t bytes() const { return bytes_; }
  std::uint32_t components() const { return components_; }

  void write(const SurfacePoint& place, std::byte* into) const {
    if (place.isCorner() || !isFloat()) {
      std::memcpy(into, at(place.triangle, place.nearestCorner()), bytes_);
    } else if (attribute_.type == ScalarType::Float32) {
      interpolate<float>(place, into);
    } else {
      interpolate<double>(place, into);
    }
  }

  /// Whether two rows are equal, up to what interpolation rounds.
  bool areEqual(const std::byte* a, const std::byte* b) const {
    if (std::memcmp(a, b, bytes_) == 0) return true;
    if (attribute_.type == ScalarType::Float32) return areNear<float>(a, b);
    return attribute_.type == ScalarType::Float64 && areNear<double>(a, b);
  }

 private:
  bool isFloat() const {
    return attribute_.type == ScalarType::Float32 || attribute_.type == ScalarType::Float64;
  }

  const std::byte* at(std::uint32_t triangle, std::size_t corner) const {
    return ofVertices_ ? attribute_.row(before_.triangles[triangle][corner])
                       : attribute_.row(triangle) + corner * bytes_;
  }

  template <class Number>
  void findLargest() {
    for (std::size_t i = 0; i < attribute_.values.size() / sizeof(Number); ++i) {
      const double size = std::abs(double{numberAt<Number>(attribute_.values.data(), i)});
      if (std::isfinite(size)) largest_ = std::max(largest_, size);
    }
  }

  template <class Number>
  void interpolate(const SurfacePoint& place, std::byte* into) const {
    for (std::size_t i = 0; i < components_; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        // A corner without weight has no influence, not even if its value is not finite.
        if (place.weights[k] == 0) continue;
        sum += place.weights[k] * double{numberAt<Number>(at(place.triangle, k), i)};
      }
      const auto number = static_cast<Number>(sum);
      std::memcpy(into + i * sizeof(Number), &number, sizeof(Number));
    }
  }

  template <class Number>
  bool areNear(const std::byte* a, const std::byte* b) const {
    // A few last digits of weights and of sums.
    constexpr double kOfLargest = 64 * double{std::numeric_limits<Number>::epsilon()};
    for (std::size_t i = 0; i < components_; ++i) {
      const double apart = double{numberAt<Number>(a, i)} - double{numberAt<Number>(b, i)};
      if (!(std::abs(apart) <= kOfLargest * largest_)) return false;
    }
    return true;
  }

  const Attribute& attribute_;
  const TriangleMesh& before_;
  bool ofVertices_;
  std::uint32_t components_;
  std::size_t bytes_;
  double largest_ = 0;  ///< of the numbers, in size
};

Attribute cornerAttribute(const Attribute& attribute, const CornerValues& values,
                          const std::vector<SurfacePoint>& corners) {
  Attribute made{attribute.name, Domain::Cell, attribute.type, 3 * values.components(), {}};
  if (attribute.domain == Domain::Vertex) made.name += model::kCornersOf;
  made.values.resize(corners.size() * values.bytes());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    values.write(corners[i], made.values.data() + i * values.bytes());
  }
  return made;
}

struct VertexValues {
  Attribute attribute;
  bool areUnique = true;  ///< whether all corners at each vertex have the same value
};

VertexValues vertexAttribute(const Attribute& attribute, const CornerValues& values,
                             const std::vector<SurfacePoint>& corners, const TriangleMesh& after) {
  VertexValues result{{attribute.name, Domain::Vertex, attribute.type, attribute.components, {}}};
  Attribute& made = result.attribute;
  made.values.resize(after.vertices.size() * values.bytes());
  std::vector<bool> isSet(after.vertices.size());
  std::vector<std::byte> value(values.bytes());
  // Rows that are kept come first: those that are interpolated are equal up to rounding.
  for (const bool kept : {true, false}) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i].isCorner() != kept) continue;
      const std::uint32_t vertex = after.triangles[i / 3][i % 3];
      std::byte* const row = made.values.data() + vertex * values.bytes();
      values.write(corners[i], isSet[vertex] ? value.data() : row);
      if (isSet[vertex] && !values.areEqual(row, value.data())) result.areUnique = false;
      isSet[vertex] = true;
    }
  }
  return result;
}

bool isOfCorners(const Attribute& attribute) {
  return attribute.domain == Domain::Cell && attribute.name.ends_with(model::kCornersOf) &&
         attribute.components % 3 == 0;
}

}  // namespace

std::vector<Attribute> carriedAttributes(const TriangleMesh& before,
                                         std::span<const Triangle> merged,
                                         const TriangleMesh& after,
                                         std::span<const VertexOrigin> origins) {
  if (before.attributes.empty()) return {};
  const Descent descent = Tracer(before, merged, after, origins).trace();
  std::vector<SurfacePoint> ofVertices;
  if (origins.empty()) ofVertices = nearestPlaces(before, after);
  const auto isTaken = [&](const std::string& name) {
    return std::ranges::find(before.attributes, name, &Attribute::name) != before.attributes.end();
  };
  std::vector<Attribute> carried;
  for (const Attribute& attribute : before.attributes) {
    if (attribute.domain == Domain::Cell && !isOfCorners(attribute)) {
      carried.push_back(rowsOf(attribute, descent.triangles));
      continue;
    }
    const CornerValues values(attribute, before);
    if (attribute.domain == Domain::Vertex && origins.empty()) {
      Attribute made = attribute;
      made.values.resize(ofVertices.size() * values.bytes());
      for (std::size_t i = 0; i < ofVertices.size(); ++i) {
        values.write(ofVertices[i], made.values.data() + i * values.bytes());
      }
      carried.push_back(std::move(made));
      continue;
    }
    if (attribute.domain == Domain::Vertex) {
      VertexValues made = vertexAttribute(attribute, values, descent.corners, after);
      if (made.areUnique || isTaken(attribute.name + std::string(model::kCornersOf))) {
        carried.push_back(std::move(made.attribute));
        continue;
      }
    }
    carried.push_back(cornerAttribute(attribute, values, descent.corners));
  }
  return carried;
}

}  // namespace t4d::edit
