#include "tools/t4d/slice_tracks.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <tuple>

#include "convert/attribute_colors.h"
#include "measure/winding_number.h"
#include "model/union_find.h"

namespace t4d::tools {
namespace {

using model::Point3;
using model::TriangleMesh;

/// One of the connected surfaces of a slice.
struct Surface {
  std::vector<std::uint32_t> triangles;
  model::Bounds3 bounds;
  double volume = 0;
  std::uint64_t track = 0;
};

/// The surfaces of a slice. Triangles are connected across edges, and not where surfaces touch at a
/// vertex, since just after that time they need not.
std::vector<Surface> surfacesOf(const TriangleMesh& slice) {
  struct Side {
    std::uint32_t low;
    std::uint32_t high;
    std::uint32_t triangle;
  };
  std::vector<Side> sides;
  sides.reserve(3 * slice.triangles.size());
  for (std::uint32_t t = 0; t < slice.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(slice.triangles[t][i], slice.triangles[t][(i + 1) % 3]);
      sides.push_back({low, high, t});
    }
  }
  std::ranges::sort(sides, {},
                    [](const Side& side) { return std::tie(side.low, side.high, side.triangle); });
  model::UnionFind sets(slice.triangles.size());
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (sides[i].low == sides[i - 1].low && sides[i].high == sides[i - 1].high) {
      sets.unite(sides[i].triangle, sides[i - 1].triangle);
    }
  }
  std::map<std::uint32_t, Surface> found;
  for (std::uint32_t t = 0; t < slice.triangles.size(); ++t) {
    Surface& surface = found[sets.root(t)];
    surface.triangles.push_back(t);
    const auto& [i, j, k] = slice.triangles[t];
    const Point3& about = slice.vertices[slice.triangles[surface.triangles.front()][0]];
    const Point3 a = slice.vertices[i] - about;
    const Point3 b = slice.vertices[j] - about;
    surface.volume += a.dot(b.cross(slice.vertices[k] - about)) / 6;
    for (const std::uint32_t vertex : slice.triangles[t]) {
      surface.bounds.add(slice.vertices[vertex]);
    }
  }
  std::vector<Surface> surfaces;
  surfaces.reserve(found.size());
  for (auto& [root, surface] : found) surfaces.push_back(std::move(surface));
  return surfaces;
}

double distanceOf(const model::Bounds3& a, const model::Bounds3& b) {
  return std::max((a.min - b.min).cwiseAbs().maxCoeff(), (a.max - b.max).cwiseAbs().maxCoeff());
}

TriangleMesh meshOf(const TriangleMesh& slice, const Surface& surface) {
  TriangleMesh mesh;
  mesh.vertices = slice.vertices;
  for (const std::uint32_t t : surface.triangles) mesh.triangles.push_back(slice.triangles[t]);
  return mesh;
}

/// The track of the smallest solid around a cavity.
std::uint64_t trackAround(const Surface& cavity, const std::vector<Surface>& surfaces,
                          const TriangleMesh& slice) {
  const Point3& place = slice.vertices[slice.triangles[cavity.triangles.front()][0]];
  double least = std::numeric_limits<double>::infinity();
  std::uint64_t track = 0;
  for (const Surface& outer : surfaces) {
    const bool holds = outer.volume >= 0 && outer.volume < least &&
                       (outer.bounds.min.array() <= place.array()).all() &&
                       (outer.bounds.max.array() >= place.array()).all();
    if (!holds || measure::WindingNumber::exactAt(meshOf(slice, outer), place) < 0.5) continue;
    least = outer.volume;
    track = outer.track;
  }
  return track;
}

}  // namespace

formats::Color trackColor(std::uint64_t id) {
  return id == 0 ? formats::Color{0.5, 0.5, 0.5, 1} : convert::distinctColor(id);
}

SliceTracks::SliceTracks(const TrackReport& report) {
  for (const BodyTracks& body : report.bodies) {
    for (std::uint32_t i = 0; i < body.tracks.tracks.size(); ++i) {
      for (const measure::TrackSample& sample : body.tracks.tracks[i].samples) {
        places_[body.name][sample.measures.time].push_back(
            {body.firstId + i, sample.measures.bounds});
      }
    }
  }
}

std::vector<std::uint64_t> SliceTracks::of(const std::string& body, const TriangleMesh& slice,
                                           double time) const {
  std::vector<std::uint64_t> tracks(slice.triangles.size(), 0);
  const auto ofBody = places_.find(body);
  if (ofBody == places_.end() || slice.triangles.empty()) return tracks;
  // The sample at this time, which may be rounded.
  auto at = ofBody->second.lower_bound(time);
  if (at == ofBody->second.end() ||
      (at != ofBody->second.begin() && time - std::prev(at)->first < at->first - time)) {
    --at;
  }
  // The points are the same, computed in another order.
  constexpr double kRounding = 1e-9;
  const model::Bounds3 all = model::boundsOf(slice);
  const double near =
      kRounding * std::max({(all.max - all.min).maxCoeff(), all.min.cwiseAbs().maxCoeff(),
                            all.max.cwiseAbs().maxCoeff()});
  std::vector<Surface> surfaces = surfacesOf(slice);
  for (Surface& surface : surfaces) {
    if (surface.volume < 0) continue;
    double least = near;
    for (const Place& place : at->second) {
      const double distance = distanceOf(place.bounds, surface.bounds);
      if (distance > least) continue;
      least = distance;
      surface.track = place.track;
    }
  }
  for (Surface& surface : surfaces) {
    if (surface.volume < 0) surface.track = trackAround(surface, surfaces, slice);
    for (const std::uint32_t t : surface.triangles) tracks[t] = surface.track;
  }
  return tracks;
}

}  // namespace t4d::tools
