#pragma once

#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "model/streamed_slab.h"

namespace t4d::model {

/// Discards slabs: for reading a source through, and for timing producers.
class NullSink : public Sink {
 public:
  Result<void> put(const Slab& /*slab*/) override { return {}; }
  Result<void> putStreamed(const StreamedSlab& /*slab*/) override { return {}; }
};

/// Collects the names of the attributes of all slabs, and passes the slabs on.
class AttributeNames : public Sink {
 public:
  /// The sink must outlive this one.
  explicit AttributeNames(Sink& next) : next_(next) {}

  Result<void> put(const Slab& slab) override { return putPrepared(slab, prepare(slab).get()); }
  std::unique_ptr<Prepared> prepare(const Slab& slab) const override { return next_.prepare(slab); }
  Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
    if (slab.connectivity) note(slab.connectivity->cellAttributes);
    note(slab.attributes);
    return next_.putPrepared(slab, prepared);
  }
  const std::set<std::string>& names() const { return names_; }

 private:
  void note(const std::vector<Attribute>& attributes) {
    for (const Attribute& attribute : attributes) names_.insert(attribute.name);
  }

  Sink& next_;
  std::set<std::string> names_;
};

/// Passes each slab to several sinks, in the order given. The first error ends the stream.
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
  std::unique_ptr<Prepared> prepare(const Slab& slab) const override {
    auto all = std::make_unique<PreparedAll>();
    for (const Sink* sink : sinks_) all->each.push_back(sink->prepare(slab));
    return all;
  }
  Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
    const auto& all = static_cast<const PreparedAll&>(*prepared);
    for (std::size_t i = 0; i < sinks_.size(); ++i) {
      if (auto done = sinks_[i]->putPrepared(slab, all.each[i].get()); !done) return done;
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
  struct PreparedAll : Prepared {
    std::vector<std::unique_ptr<Prepared>> each;
  };

  std::vector<Sink*> sinks_;
};

}  // namespace t4d::model
