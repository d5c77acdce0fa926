#include "measure/body_contacts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "measure/level_surfaces.h"
#include "model/parallel.h"
#include "slice/cut.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;
using model::Point4;
using model::Slab;
using model::TimeSpan;

using Pair = std::pair<std::uint32_t, std::uint32_t>;  // of bodies, the smaller number first

struct SlabOfBody {
  std::uint32_t body;
  std::size_t slab;
};
using Spans = std::map<std::pair<double, double>, std::vector<SlabOfBody>>;

Spans spansOf(std::span<const model::Body> bodies) {
  Spans spans;
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    for (std::size_t i = 0; i < bodies[b].source->slabCount(); ++i) {
      const TimeSpan span = bodies[b].source->timeSpan(i);
      if (span.begin < span.end) spans[{span.begin, span.end}].push_back({b, i});
    }
  }
  return spans;
}

struct HeldSlab {
  std::uint32_t body;
  std::shared_ptr<const Slab> slab;
};

/// For each vertex of the slabs of one span, the bodies that have it.
class SharedVertices {
 public:
  explicit SharedVertices(std::span<const HeldSlab> slabs) {
    struct Entry {
      std::uint64_t hash;
      std::uint32_t slab;
      std::uint32_t vertex;
    };
    std::vector<Entry> entries;
    for (std::uint32_t s = 0; s < slabs.size(); ++s) {
      const std::vector<Point4>& vertices = slabs[s].slab->vertices;
      setOfVertex_.emplace_back(vertices.size(), kNoIndex);
      for (std::uint32_t v = 0; v < vertices.size(); ++v) {
        entries.push_back({hashOf(vertices[v]), s, v});
      }
    }
    std::ranges::sort(entries, {}, [](const Entry& entry) {
      return std::tuple(entry.hash, entry.slab, entry.vertex);
    });
    const auto pointOf = [&](const Entry& entry) -> const Point4& {
      return slabs[entry.slab].slab->vertices[entry.vertex];
    };
    for (std::size_t i = 0; i < entries.size();) {
      std::size_t end = i + 1;
      while (end < entries.size() && entries[end].hash == entries[i].hash) ++end;
      // Different points of one hash are as good as none.
      const auto isSame = [&](const Entry& entry) { return pointOf(entry) == pointOf(entries[i]); };
      const auto run = std::span(entries).subspan(i, end - i);
      if (run.size() > 1 && std::ranges::all_of(run, isSame)) {
        std::vector<std::uint32_t> bodies;
        for (const Entry& entry : run) bodies.push_back(slabs[entry.slab].body);
        bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
        if (bodies.size() > 1) {
          for (const Entry& entry : run) {
            setOfVertex_[entry.slab][entry.vertex] = static_cast<std::uint32_t>(sets_.size());
          }
          sets_.push_back(std::move(bodies));
        }
      }
      i = end;
    }
  }

  bool isShared(std::uint32_t slab, std::uint32_t vertex) const {
    return setOfVertex_[slab][vertex] != kNoIndex;
  }

  /// Calls `use` with each body that has all these vertices of a slab, but not the slab's own.
  template <class Use>
  void forBodies(std::uint32_t slab, std::uint32_t own, std::span<const std::uint32_t> vertices,
                 Use use) const {
    for (const std::uint32_t vertex : vertices) {
      if (!isShared(slab, vertex)) return;
    }
    for (const std::uint32_t body : sets_[setOfVertex_[slab][vertices.front()]]) {
      const auto has = [&](std::uint32_t vertex) {
        return std::ranges::binary_search(sets_[setOfVertex_[slab][vertex]], body);
      };
      if (body != own && std::ranges::all_of(vertices, has)) use(body);
    }
  }

 private:
  static std::uint64_t hashOf(const Point4& point) {
    std::uint64_t hash = 0x9E3779B97F4A7C15U;
    for (const double x : point) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0xBF58476D1CE4E5B9U;  // -0 is 0
      hash ^= hash >> 29U;
    }
    return hash;
  }

  std::vector<std::vector<std::uint32_t>> sets_;         // of bodies, increasing
  std::vector<std::vector<std::uint32_t>> setOfVertex_;  // of each slab
};

/// Finds the contacts in the slabs of one span.
class SpanContacts {
 public:
  SpanContacts(std::span<const HeldSlab> slabs, const TimeSpan& span)
      : slabs_(slabs), span_(span), shared_(slabs) {}

  std::vector<BodyContact> find(std::span<const double> samples) {
    addCells();
    const auto atBegin = areasAt(span_.begin);
    const auto atEnd = areasAt(span_.end);
    for (const auto& [pair, area] : atBegin) {
      add(pair, span_.begin, atEnd.contains(pair) ? span_.end : span_.begin, area);
    }
    for (const auto& [pair, area] : atEnd) add(pair, span_.end, span_.end, area);
    std::set<double> middles;
    for (const auto& [pair, contacts] : found_) {
      if (atBegin.contains(pair) || atEnd.contains(pair)) continue;
      for (const BodyContact& one : contacts) middles.insert(one.begin + (one.end - one.begin) / 2);
    }
    for (const double time : middles) {
      for (const auto& [pair, area] : areasAt(time)) add(pair, time, time, area);
    }
    std::vector<BodyContact> all;
    for (auto& [pair, contacts] : found_) {
      all.insert(all.end(), contacts.begin(), contacts.end());
    }
    all = joinedContacts(std::move(all));
    for (const double time : samples) {
      const auto areas = time == span_.begin ? atBegin : time == span_.end ? atEnd : areasAt(time);
      for (BodyContact& contact : all) {
        if (time < contact.begin || time > contact.end) continue;
        const auto at = areas.find(pairOf(contact.body, contact.other));
        contact.samples.push_back({time, at == areas.end() ? 0 : at->second});
        contact.largestArea = std::max(contact.largestArea, contact.samples.back().area);
      }
    }
    return all;
  }

 private:
  static Pair pairOf(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax(a, b);
    return {static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(high)};
  }

  void add(const Pair& pair, double begin, double end, double area) {
    found_[pair].push_back({pair.first, pair.second, begin, end, area});
  }

  /// The times of cells of which another body has all vertices.
  void addCells() {
    for (std::uint32_t s = 0; s < slabs_.size(); ++s) {
      const Slab& slab = *slabs_[s].slab;
      for (const model::Cell& cell : slab.connectivity->cells) {
        shared_.forBodies(s, slabs_[s].body, cell, [&](std::uint32_t other) {
          const auto [begin, end] =
              std::minmax({slab.vertices[cell[0]][3], slab.vertices[cell[1]][3],
                           slab.vertices[cell[2]][3], slab.vertices[cell[3]][3]});
          if (begin == end) return;
          std::vector<BodyContact>& known = found_[pairOf(slabs_[s].body, other)];
          // Most cells have the times of the one before.
          if (!known.empty() && known.back().begin <= begin && known.back().end >= end) return;
          known.push_back({std::min<std::size_t>(slabs_[s].body, other),
                           std::max<std::size_t>(slabs_[s].body, other), begin, end});
        });
      }
    }
  }

  /// The areas of contact at a time, of pairs that have any.
  std::map<Pair, double> areasAt(double time) const {
    std::map<Pair, double> areas;
    for (std::uint32_t s = 0; s < slabs_.size(); ++s) {
      const Slab& slab = *slabs_[s].slab;
      const slice::Cut cut =
          slice::cutOf(slab.connectivity->cells, verticesAfter(slab, time, time == span_.end));
      const auto points = pointsAt(cut, slab.vertices, time);
      for (const model::Triangle& triangle : cut.triangles) {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t corner : triangle) {
          const auto [below, above] = cut.points[corner];
          if (slab.vertices[above][3] > time) vertices.push_back(below);
          if (slab.vertices[below][3] < time) vertices.push_back(above);
        }
        shared_.forBodies(s, slabs_[s].body, vertices, [&](std::uint32_t other) {
          const model::Point3& a = points[triangle[0]];
          const double area = (points[triangle[1]] - a).cross(points[triangle[2]] - a).norm() / 2;
          if (area > 0) areas[pairOf(slabs_[s].body, other)] += area / 2;
        });
      }
    }
    return areas;
  }

  std::span<const HeldSlab> slabs_;
  TimeSpan span_;
  SharedVertices shared_;
  std::map<Pair, std::vector<BodyContact>> found_;
};

Result<std::vector<BodyContact>> contactsIn(std::span<const model::Body> bodies,
                                            const TimeSpan& span, std::span<const SlabOfBody> given,
                                            const std::vector<double>& times, bool atEnd) {
  std::vector<HeldSlab> slabs;
  for (const auto& [body, number] : given) {
    auto slab = bodies[body].source->slab(number);
    if (!slab) return slab.error();
    slabs.push_back({body, std::move(*slab)});
  }
  const auto first = std::ranges::lower_bound(times, span.begin);
  const auto last =
      atEnd ? std::ranges::upper_bound(times, span.end) : std::ranges::lower_bound(times, span.end);
  return SpanContacts(slabs, span).find({first, last});
}

}  // namespace

std::uint64_t contactSpanCount(std::span<const model::Body> bodies) {
  return spansOf(bodies).size();
}

Result<std::vector<BodyContact>> contactsOf(std::span<const model::Body> bodies,
                                            const TrackOptions& options,
                                            std::optional<model::PartRange> spans,
                                            const model::Progress& progress) {
  const Spans all = spansOf(bodies);
  const TimeSpan whole = model::timeSpanOf(bodies);
  std::vector<double> times = options.times;
  std::vector<Spans::const_iterator> chosen;
  std::uint64_t number = 0;
  for (auto at = all.begin(); at != all.end(); ++at, ++number) {
    if (!spans || (number >= spans->begin && number < spans->end)) chosen.push_back(at);
    if (options.layers) times.insert(times.end(), {at->first.first, at->first.second});
  }
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  std::vector<Result<std::vector<BodyContact>>> found(chosen.size(), std::vector<BodyContact>());
  const auto done = model::forEach(chosen.size(), progress, [&](std::size_t i) {
    const auto& [span, slabs] = *chosen[i];
    if (slabs.size() < 2) return;
    found[i] =
        contactsIn(bodies, {span.first, span.second}, slabs, times, span.second == whole.end);
  });
  if (!done) return done.error();
  std::vector<BodyContact> contacts;
  for (auto& one : found) {
    if (!one) return one.error();
    contacts.insert(contacts.end(), one->begin(), one->end());
  }
  return joinedContacts(std::move(contacts));
}

std::vector<BodyContact> joinedContacts(std::vector<BodyContact> contacts) {
  std::ranges::sort(contacts, {}, [](const BodyContact& one) {
    return std::tuple(one.body, one.other, one.begin, one.end);
  });
  std::vector<BodyContact> joined;
  for (BodyContact& one : contacts) {
    if (joined.empty() || joined.back().body != one.body || joined.back().other != one.other ||
        joined.back().end < one.begin) {
      joined.push_back(std::move(one));
      continue;
    }
    BodyContact& into = joined.back();
    into.end = std::max(into.end, one.end);
    into.largestArea = std::max(into.largestArea, one.largestArea);
    into.samples.insert(into.samples.end(), one.samples.begin(), one.samples.end());
  }
  for (BodyContact& one : joined) {
    std::ranges::stable_sort(one.samples, {}, &ContactSample::time);
    const auto repeated = std::ranges::unique(one.samples, {}, &ContactSample::time);
    one.samples.erase(repeated.begin(), repeated.end());
  }
  std::ranges::sort(joined, {}, [](const BodyContact& one) {
    return std::tuple(one.begin, one.body, one.other);
  });
  return joined;
}

}  // namespace t4d::measure
