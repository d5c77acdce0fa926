#pragma once

#include <utility>
#include <vector>

#include "t4d/model/slab.h"

namespace t4d::model {

/// Discards slabs: for reading a source through, and for timing producers.
class NullSink : public Sink {
 public:
  Result<void> put(const Slab& /*slab*/) override { return {}; }
};

/// Hands each slab to several sinks, in the order given. The first error ends the stream.
class Tee : public Sink {
 public:
  /// The sinks must outlive the tee.
  explicit Tee(std::vector<Sink*> sinks) : sinks_(std::move(sinks)) {}

  Result<void> put(const Slab& slab) override {
    for (Sink* sink : sinks_) {
      if (auto done = sink->put(slab); !done) return done;
    }
    return {};
  }

 private:
  std::vector<Sink*> sinks_;
};

/// Moves the vertices of all slabs by the same vector in space.
class Translated : public Sink {
 public:
  /// `into` must outlive this sink.
  Translated(Sink& into, const Eigen::Vector3d& by) : into_(into), by_(by) {}

  Result<void> put(const Slab& slab) override {
    Slab moved = slab;
    for (Point4& vertex : moved.vertices) vertex.head<3>() += by_;
    if (moved.connectivity) setMeans(*moved.connectivity, moved.vertices);
    return into_.put(moved);
  }

 private:
  Sink& into_;
  Eigen::Vector3d by_;
};

}  // namespace t4d::model
