#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "model/error.h"
#include "model/geometry.h"
#include "model/layer_pose.h"

namespace t4d::model {

/// The positions of the vertices of a triangle mesh at a sequence of times, the keys. Between two
/// keys every vertex moves along a straight line at constant speed.
class VertexKeys {
 public:
  virtual ~VertexKeys() = default;

  /// The number of keys, at least two.
  virtual std::uint64_t count() const = 0;
  /// The time of a key; increases from key to key.
  virtual double time(std::uint64_t key) const = 0;
  /// The affine map that takes the vertices of the mesh to their positions at this key; nothing if
  /// there is none. With such maps a 4D mesh takes less space in a file.
  virtual std::optional<Affine3x4> pose(std::uint64_t /*key*/) const { return std::nullopt; }
  /// The positions of all vertices at this key, in the order of the mesh. If there is a pose, they
  /// are those of `posed`. Keys may be requested in any order; ascending order is the fastest.
  virtual Result<void> positions(std::uint64_t key, std::span<Point3> into) const = 0;
};

/// Keys in memory.
class StoredKeys : public VertexKeys {
 public:
  struct Key {
    double time = 0;
    std::vector<Point3> positions = {};
  };
  explicit StoredKeys(std::vector<Key> keys) : keys_(std::move(keys)) {}

  std::uint64_t count() const override { return keys_.size(); }
  double time(std::uint64_t key) const override { return keys_[key].time; }
  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    std::copy(keys_[key].positions.begin(), keys_[key].positions.end(), into.begin());
    return {};
  }

 private:
  std::vector<Key> keys_;
};

}  // namespace t4d::model
