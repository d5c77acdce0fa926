#pragma once

#include <span>
#include <utility>
#include <vector>

#include "t4d/model/streamed_slab.h"

namespace t4d::model {

/// Discards slabs: for reading a source through, and for timing producers.
class NullSink : public Sink {
 public:
  Result<void> put(const Slab& /*slab*/) override { return {}; }
  Result<void> putStreamed(const StreamedSlab& /*slab*/) override { return {}; }
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
  Result<void> putStreamed(const StreamedSlab& slab) override {
    for (Sink* sink : sinks_) {
      if (auto done = sink->putStreamed(slab); !done) return done;
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
  Result<void> putStreamed(const StreamedSlab& slab) override {
    return into_.putStreamed(Moved(slab, by_));
  }

 private:
  class Moved : public StreamedSlab {
   public:
    Moved(const StreamedSlab& slab, const Eigen::Vector3d& by) : slab_(slab), by_(by) {
      static_cast<VertexCounts&>(*this) = slab;
      time = slab.time;
      cellCount = slab.cellCount;
    }
    void vertices(std::uint32_t first, std::span<Point4> into) const override {
      slab_.vertices(first, into);
      for (Point4& vertex : into) vertex.head<3>() += by_;
    }
    void cells(std::uint64_t first, std::span<Cell> into) const override {
      slab_.cells(first, into);
    }

   private:
    const StreamedSlab& slab_;
    const Eigen::Vector3d& by_;
  };

  Sink& into_;
  Eigen::Vector3d by_;
};

}  // namespace t4d::model
