#include "edit/give_way.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace t4d::edit {
namespace {

using model::Point3;

double kernel(double x) { return x < 1 ? (1 - x * x) * (1 - x * x) : 0; }

/// Points in cubes of a side.
class PointGrid {
 public:
  PointGrid(const std::vector<Point3>& points, double side) : points_(points), side_(side) {
    for (std::uint32_t i = 0; i < points.size(); ++i) cubes_[keyOf(cubeOf(points[i]))].push_back(i);
  }

  /// Calls visit(index, distance) for all points within a side of a place.
  template <class Visit>
  void near(const Point3& place, Visit visit) const {
    const std::array<std::int64_t, 3> middle = cubeOf(place);
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        for (std::int64_t z = -1; z <= 1; ++z) {
          const auto found = cubes_.find(keyOf({middle[0] + x, middle[1] + y, middle[2] + z}));
          if (found == cubes_.end()) continue;
          for (const std::uint32_t i : found->second) {
            const double distance = (points_[i] - place).norm();
            if (distance < side_) visit(i, distance);
          }
        }
      }
    }
  }

 private:
  std::array<std::int64_t, 3> cubeOf(const Point3& point) const {
    return {static_cast<std::int64_t>(std::floor(point[0] / side_)),
            static_cast<std::int64_t>(std::floor(point[1] / side_)),
            static_cast<std::int64_t>(std::floor(point[2] / side_))};
  }
  /// Cubes with the same key are far apart; what is in them is tested all the same.
  static std::uint64_t keyOf(const std::array<std::int64_t, 3>& cube) {
    return (static_cast<std::uint64_t>(cube[0]) & 0x1fffff) << 42 |
           (static_cast<std::uint64_t>(cube[1]) & 0x1fffff) << 21 |
           (static_cast<std::uint64_t>(cube[2]) & 0x1fffff);
  }

  const std::vector<Point3>& points_;
  double side_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cubes_;
};

struct Moved {
  double depth = 0;
  Point3 along = Point3::Zero();  // a weighted sum
};
using MovedVertices = std::map<std::uint32_t, Moved>;

}  // namespace

Result<std::vector<Point3>> placesAt(const VertexTracks& tracks, const LayerKey& key) {
  auto places = tracks.layer(key.step);
  if (!places || key.fraction == 0) return places;
  const auto next = tracks.layer(key.step + 1);
  if (!next) return next;
  for (std::size_t i = 0; i < places->size(); ++i) {
    (*places)[i] = between((*places)[i], (*next)[i], key.fraction);
  }
  return places;
}

Result<Displacement> spread(const VertexTracks& tracks, const std::map<LayerKey, double>& layers,
                            const Pushes& pushes, const Spread& by) {
  std::map<LayerKey, MovedVertices> moved;
  for (const auto& [from, layerPushes] : pushes) {
    if (layerPushes.empty()) continue;
    const auto places = placesAt(tracks, from);
    if (!places) return places.error();
    const PointGrid grid(*places, by.space);
    MovedVertices inSpace;
    for (const auto& [vertex, push] : layerPushes) {
      grid.near((*places)[vertex], [&](std::uint32_t other, double distance) {
        const double weight = kernel(distance / by.space);
        Moved& one = inSpace[other];
        one.depth = std::max(one.depth, weight * push.depth);
        one.along += weight * push.depth * push.along;
      });
    }
    const double time = layers.at(from);
    for (const auto& [to, toTime] : layers) {
      const double weight = to == from || (by.stay && toTime > time) ? 1
                            : by.time > 0 ? kernel(std::abs(toTime - time) / by.time)
                                          : 0;
      if (weight == 0) continue;
      MovedVertices& layer = moved[to];
      for (const auto& [vertex, one] : inSpace) {
        Moved& all = layer[vertex];
        all.depth = std::max(all.depth, weight * one.depth);
        all.along += weight * one.along;
      }
    }
  }
  Displacement displacement;
  for (const auto& [key, time] : layers) {
    if (key.fraction != 0) displacement[key];
  }
  for (const auto& [key, vertices] : moved) {
    LayerDisplacement& layer = displacement[key];
    for (const auto& [vertex, one] : vertices) {
      const double length = one.along.norm();
      if (!(one.depth > 0) || !(length > 0)) continue;
      layer.emplace_back(vertex, one.along * (one.depth / length));
    }
  }
  return displacement;
}

}  // namespace t4d::edit
