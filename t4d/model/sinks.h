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

}  // namespace t4d::model
