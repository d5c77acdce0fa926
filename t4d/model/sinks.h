#pragma once

#include <set>
#include <span>
#include <string>
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

/// Notes the names of the attributes of all slabs, and passes the slabs on.
class AttributeNames : public Sink {
 public:
  /// The sink must outlive this one.
  explicit AttributeNames(Sink& next) : next_(next) {}

  Result<void> put(const Slab& slab) override {
    if (slab.connectivity) note(slab.connectivity->cellAttributes);
    note(slab.attributes);
    return next_.put(slab);
  }
  const std::set<std::string>& names() const { return names_; }

 private:
  void note(const std::vector<Attribute>& attributes) {
    for (const Attribute& attribute : attributes) names_.insert(attribute.name);
  }

  Sink& next_;
  std::set<std::string> names_;
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
