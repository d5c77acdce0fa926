#include "measure/pair_search.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "measure/cell_pair.h"
#include "measure/hull_distance.h"
#include "measure/moving_box.h"
#include "measure/overlap.h"
#include "model/parallel.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::Bounds4;
using model::Slab;
using model::Source;
using model::TimeSpan;

bool lasts(const TimeSpan& span) { return span.end > span.begin; }

/// All windows in time order. One that is an instant only counts if no other includes it, as
/// between two bodies of which one starts when the other ends.
std::vector<SlabWindow> windowsOf(const Source& a, const Source& b) {
  std::vector<SlabWindow> windows;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.slabCount() && j < b.slabCount()) {
    const TimeSpan p = a.timeSpan(i);
    const TimeSpan q = b.timeSpan(j);
    const TimeSpan common{std::max(p.begin, q.begin), std::min(p.end, q.end)};
    if (lasts(p) && lasts(q) && common.begin <= common.end) {
      // Instants come before or after the windows that include them.
      const bool instant = !lasts(common);
      const bool known = !windows.empty() && windows.back().span.end == common.begin;
      if (!instant && !windows.empty() && !lasts(windows.back().span) &&
          windows.back().span.end == common.begin) {
        windows.pop_back();
      }
      if (!instant || !known) windows.push_back({common, i, j});
    }
    if (p.end < q.end || (p.end == q.end && !lasts(p))) {
      ++i;
    } else if (q.end < p.end || !lasts(q)) {
      ++j;
    } else if (i + 1 < a.slabCount() && j + 1 < b.slabCount()) {
      // Both end: the one whose next slab comes first goes on.
      ++(a.timeSpan(i + 1).begin <= b.timeSpan(j + 1).begin ? i : j);
    } else {
      ++(i + 1 < a.slabCount() ? i : j);
    }
  }
  return windows;
}

CellCorners cornersOf(const Slab& slab, std::uint32_t cell) {
  const model::Cell& corners = slab.connectivity->cells[cell];
  return {slab.vertices[corners[0]], slab.vertices[corners[1]], slab.vertices[corners[2]],
          slab.vertices[corners[3]]};
}

/// The moving box of a cell that lasts.
MovingBox boxOf(const CellCorners& corners) {
  TimeSpan time{corners[0][3], corners[0][3]};
  for (const model::Point4& corner : corners) {
    time.begin = std::min(time.begin, corner[3]);
    time.end = std::max(time.end, corner[3]);
  }
  return movingBoxOf(corners, time);
}

struct NodePair {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
};

struct LeafCell {
  std::uint32_t number = 0;
  CellCorners corners;
  MovingBox box;
};

/// The search in one window.
class WindowSearch {
 public:
  WindowSearch(const LoadedSlab& a, const LoadedSlab& b, const TimeSpan& span)
      : a_(a), b_(b), span_(span) {}

  /// Adds when cells meet.
  void findContacts(ContactStretches& stretches) const {
    const auto near = [](const MovingBox& p, const MovingBox& q) {
      return meetingTime(p, q).has_value();
    };
    const std::vector<NodePair> tasks = split(near);
    std::vector<ContactStretches> found(tasks.size());
    // Findings of earlier batches save later ones work. Batches are the same for any number of
    // threads, and so is the result.
    constexpr std::size_t kLargestBatch = 64;
    std::size_t end = 0;
    for (std::size_t begin = 0; begin < tasks.size(); begin = end) {
      end = std::min({tasks.size(), 2 * begin + 1, begin + kLargestBatch});
      model::forEach(end - begin, [&](std::size_t i) {
        const std::size_t task = begin + i;
        found[task] = stretches;
        findContacts(tasks[task], found[task]);
      });
      for (std::size_t task = begin; task < end; ++task) {
        stretches.add(found[task]);
        found[task] = {};
      }
    }
  }

  /// Replaces `best` if there are nearer cells.
  void findNearest(Clearance& best) const {
    if (a_.tree().nodes().empty() || b_.tree().nodes().empty()) return;
    std::atomic<double> bound = best.distance;
    const auto near = [&](const MovingBox& p, const MovingBox& q) {
      return leastDistance(p, q) <= bound.load(std::memory_order_relaxed);
    };
    std::vector<NodePair> tasks = split(near);
    const auto distance = [&](const NodePair& pair) {
      return leastDistance(a_.tree().nodes()[pair.a].box, b_.tree().nodes()[pair.b].box);
    };
    std::ranges::stable_sort(tasks, {}, distance);
    std::vector<Clearance> found(tasks.size(), best);
    model::forEach(tasks.size(),
                   [&](std::size_t task) { findNearest(tasks[task], bound, found[task]); });
    for (const Clearance& one : found) {
      const double proven = std::min(best.lowerBound, one.lowerBound);
      if (isNearer(one, best)) best = one;
      best.lowerBound = proven;
    }
  }

  /// The distance of two cells as an upper bound.
  void tryCells(std::uint32_t cellA, std::uint32_t cellB, Clearance& best) const {
    if (cellA >= a_.slab().connectivity->cells.size()) return;
    if (cellB >= b_.slab().connectivity->cells.size()) return;
    tryCells(cellA, cornersOf(a_.slab(), cellA), cellB, cornersOf(b_.slab(), cellB),
             std::numeric_limits<double>::infinity(), best);
  }

 private:
  /// Pairs of nodes that are near, enough of them for all threads.
  template <class Near>
  std::vector<NodePair> split(const Near& near) const {
    constexpr std::size_t kEnough = 1024;
    std::vector<NodePair> pairs;
    if (a_.tree().nodes().empty() || b_.tree().nodes().empty()) return pairs;
    pairs.push_back({0, 0});
    for (bool grown = true; grown && pairs.size() < kEnough;) {
      grown = false;
      std::vector<NodePair> next;
      for (const NodePair& pair : pairs) {
        if (!near(a_.tree().nodes()[pair.a].box, b_.tree().nodes()[pair.b].box)) continue;
        if (!forEachChild(pair, [&](const NodePair& child) { next.push_back(child); })) {
          next.push_back(pair);
        } else {
          grown = true;
        }
      }
      pairs = std::move(next);
    }
    return pairs;
  }

  /// False for two leaves. Divides the larger one otherwise.
  template <class Visit>
  bool forEachChild(const NodePair& pair, Visit visit) const {
    const CellTree::Node& nodeA = a_.tree().nodes()[pair.a];
    const CellTree::Node& nodeB = b_.tree().nodes()[pair.b];
    if (nodeA.isLeaf() && nodeB.isLeaf()) return false;
    const auto size = [](const CellTree::Node& node) {
      return (node.box.begin.max - node.box.begin.min).squaredNorm();
    };
    if (nodeB.isLeaf() || (!nodeA.isLeaf() && size(nodeA) >= size(nodeB))) {
      visit(NodePair{pair.a + 1, pair.b});
      visit(NodePair{nodeA.second, pair.b});
    } else {
      visit(NodePair{pair.a, pair.b + 1});
      visit(NodePair{pair.a, nodeB.second});
    }
    return true;
  }

  /// The cells of a leaf that last and meet the box, in `into`; returns their number.
  static std::size_t cellsOf(const Slab& slab, const CellTree::Node& leaf, const auto& near,
                             std::array<LeafCell, CellTree::kMostCells>& into) {
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < leaf.cellCount; ++i) {
      LeafCell& cell = into[count];
      cell.number = leaf.firstCell + i;
      cell.corners = cornersOf(slab, cell.number);
      cell.box = boxOf(cell.corners);
      if (lasts(cell.box.time) && near(cell.box)) ++count;
    }
    return count;
  }

  /// Calls visit(cell of a, cell of b) for pairs of two leaves that are near.
  template <class Near, class Visit>
  void forEachCellPair(const NodePair& pair, const Near& near, Visit visit) const {
    const CellTree::Node& nodeA = a_.tree().nodes()[pair.a];
    const CellTree::Node& nodeB = b_.tree().nodes()[pair.b];
    std::array<LeafCell, CellTree::kMostCells> cellsA;
    std::array<LeafCell, CellTree::kMostCells> cellsB;
    const std::size_t countA = cellsOf(
        a_.slab(), nodeA, [&](const MovingBox& p) { return near(p, nodeB.box); }, cellsA);
    if (countA == 0) return;
    const std::size_t countB = cellsOf(
        b_.slab(), nodeB, [&](const MovingBox& q) { return near(nodeA.box, q); }, cellsB);
    for (std::size_t i = 0; i < countA; ++i) {
      for (std::size_t j = 0; j < countB; ++j) {
        if (near(cellsA[i].box, cellsB[j].box)) visit(cellsA[i], cellsB[j]);
      }
    }
  }

  void findContacts(const NodePair& pair, ContactStretches& stretches) const {
    const auto near = [&](const MovingBox& p, const MovingBox& q) {
      const auto time = meetingTime(p, q);
      return time && !stretches.covers(time->begin, time->end);
    };
    if (!near(a_.tree().nodes()[pair.a].box, b_.tree().nodes()[pair.b].box)) return;
    if (forEachChild(pair, [&](const NodePair& child) { findContacts(child, stretches); })) return;
    if (areFarther(a_.tree().nodes()[pair.a], b_.tree().nodes()[pair.b], 0)) return;
    forEachCellPair(pair, near, [&](const LeafCell& p, const LeafCell& q) {
      const auto time = meetingTime(p.box, q.box);
      const bool known = time && stretches.includes(time->begin, time->end);
      const auto meeting = meetingOf(p.corners, q.corners, /*crossingsOnly=*/known);
      if (!meeting) return;
      ContactStretch stretch;
      stretch.begin = std::clamp(meeting->timeBegin, span_.begin, span_.end);
      stretch.end = std::clamp(meeting->timeEnd, stretch.begin, span_.end);
      // Solids that have an instant in common only have no common interior.
      stretch.overlaps = (meeting->crosses || meeting->coincides) && lasts(span_);
      if (stretch.overlaps) stretch.crossing = {stretch.begin, stretch.end};
      stretch.first = {stretch.begin, meeting->point, CellNumber{a_.number(), p.number},
                       CellNumber{b_.number(), q.number}};
      stretch.last = stretch.first;
      stretches.add(stretch);
    });
  }

  /// Whether the hulls of two leaves are certainly farther from each other.
  bool areFarther(const CellTree::Node& leafA, const CellTree::Node& leafB, double distance) const {
    static_assert(CellTree::kMostVertices <= kMostHullPoints);
    using Hull = std::array<model::Point4, CellTree::kMostVertices>;
    Hull hullA;
    Hull hullB;
    const auto pointsOf = [](const LoadedSlab& side, const CellTree::Node& leaf, Hull& into) {
      std::size_t count = 0;
      for (const std::uint32_t vertex : side.tree().verticesOf(leaf)) {
        into[count++] = side.slab().vertices[vertex];
      }
      return std::span<const model::Point4>(into).first(count);
    };
    const auto found = distanceOf(pointsOf(a_, leafA, hullA), pointsOf(b_, leafB, hullB), distance);
    return !found || found->lowerBound > distance;
  }

  static bool isNearer(const Clearance& one, const Clearance& other) {
    if (one.distance != other.distance) return one.distance < other.distance;
    return std::pair(one.a.cell, one.b.cell) < std::pair(other.a.cell, other.b.cell);
  }

  void tryCells(std::uint32_t numberA, const CellCorners& a, std::uint32_t numberB,
                const CellCorners& b, double enough, Clearance& best) const {
    // Below the distance by rounding errors, unless the search for it got stuck.
    constexpr double kProven = 1e-9;
    const auto found = distanceOf(a, b, enough);
    if (!found || found->lowerBound > enough) return;
    const Clearance one{found->distance,       found->lowerBound, found->time,
                        found->pointA,         found->pointB,     {a_.number(), numberA},
                        {b_.number(), numberB}};
    const bool stuck = one.lowerBound < one.distance * (1 - kProven) - kProven * size();
    const double proven = stuck ? std::min(best.lowerBound, one.lowerBound) : best.lowerBound;
    if (isNearer(one, best)) {
      best = one;
      best.lowerBound = std::min(one.lowerBound, proven);
    } else {
      best.lowerBound = proven;
    }
  }

  void findNearest(const NodePair& pair, std::atomic<double>& bound, Clearance& best) const {
    const auto near = [&](const MovingBox& p, const MovingBox& q) {
      return leastDistance(p, q) <= bound.load(std::memory_order_relaxed);
    };
    const CellTree::Node& nodeA = a_.tree().nodes()[pair.a];
    const CellTree::Node& nodeB = b_.tree().nodes()[pair.b];
    if (!near(nodeA.box, nodeB.box)) return;
    std::array<NodePair, 2> children;
    std::size_t count = 0;
    if (forEachChild(pair, [&](const NodePair& child) { children[count++] = child; })) {
      const auto distance = [&](const NodePair& child) {
        return leastDistance(a_.tree().nodes()[child.a].box, b_.tree().nodes()[child.b].box);
      };
      if (distance(children[1]) < distance(children[0])) std::swap(children[0], children[1]);
      for (const NodePair& child : children) findNearest(child, bound, best);
      return;
    }
    if (areFarther(nodeA, nodeB, bound.load(std::memory_order_relaxed))) return;
    forEachCellPair(pair, near, [&](const LeafCell& p, const LeafCell& q) {
      tryCells(p.number, p.corners, q.number, q.corners, bound.load(std::memory_order_relaxed),
               best);
      double known = bound.load(std::memory_order_relaxed);
      while (best.distance < known && !bound.compare_exchange_weak(known, best.distance)) {
      }
    });
  }

  double size() const {
    const Bounds4 p = a_.tree().bounds();
    const Bounds4 q = b_.tree().bounds();
    return (p.max.cwiseMax(q.max) - p.min.cwiseMin(q.min)).head<3>().norm();
  }

  const LoadedSlab& a_;
  const LoadedSlab& b_;
  TimeSpan span_;
};

/// Two times that differ by the rounding of sums of steps only.
bool sameTime(double p, double q) {
  return std::abs(p - q) <= model::kSameTimeUlps * std::numeric_limits<double>::epsilon() *
                                std::max(std::abs(p), std::abs(q));
}

Clearance noClearance() {
  Clearance none;
  none.distance = none.lowerBound = std::numeric_limits<double>::infinity();
  return none;
}

}  // namespace

Result<void> LoadedSlab::load(std::size_t index, const TimeSpan& window) {
  if (index != number_) {
    slab_.reset();
    auto read = source_->slab(index);
    if (!read) return read.error();
    slab_ = std::move(*read);
    number_ = index;
  } else if (window.begin == window_.begin && window.end == window_.end) {
    return {};
  }
  tree_.fit(*slab_, window);
  window_ = window;
  return {};
}

PairSearch::PairSearch(const LoadedSlab& a, const LoadedSlab& b, const CollideOptions& options)
    : options_(options),
      a_(a),
      b_(b),
      windows_(windowsOf(a.source(), b.source())),
      apart_(windows_.size(), 0),
      nearest_(noClearance()) {}

Result<void> PairSearch::findContacts(std::size_t window) {
  const TimeSpan& span = windows_[window].span;
  const auto nodesA = a_.tree().nodes();
  const auto nodesB = b_.tree().nodes();
  apart_[window] = nodesA.empty() || nodesB.empty()
                       ? std::numeric_limits<double>::infinity()
                       : leastDistance(nodesA.front().box, nodesB.front().box);
  if (apart_[window] == 0) {
    const bool continued = !open_.empty() && open_.all().back().end == span.begin;
    const bool touching = lastWindowEnd_ == span.begin && !continued;
    WindowSearch(a_, b_, span).findContacts(open_);
    roundOnce();
    if (auto done = findInside(span, touching); !done) return done;
    join();
    lastWindowEnd_ = span.end;
  }
  finishBefore(span.end);
  return {};
}

void PairSearch::finishContacts() { finishBefore(std::numeric_limits<double>::infinity()); }

bool PairSearch::findsClearance() const {
  return options_.clearanceOverTime || (options_.clearance && intervals_.empty());
}

/// Rounds the ends of stretches in the window once, where cells meet.
void PairSearch::roundOnce() {
  ContactStretches rounded;
  for (ContactStretch stretch : open_.all()) {
    const auto meeting = [&](const Contact& contact) {
      return meetingRoundedOnce(cornersOf(a_.slab(), static_cast<std::uint32_t>(contact.a->cell)),
                                cornersOf(b_.slab(), static_cast<std::uint32_t>(contact.b->cell)));
    };
    if (!stretch.beginKnown) {
      if (const auto found = meeting(stretch.first)) {
        stretch.begin = stretch.first.time = found->timeBegin;
        stretch.first.point = found->point;
      }
      stretch.beginKnown = true;
    }
    if (!stretch.endKnown) {
      if (const auto found = meeting(stretch.last)) {
        stretch.end = std::max(stretch.begin, found->timeEnd);
      }
      stretch.endKnown = true;
    }
    rounded.add(stretch);
  }
  open_ = std::move(rounded);
}

/// Adds the times between contacts when a part of one surface is inside the other.
Result<void> PairSearch::findInside(const TimeSpan& span, bool continued) {
  std::vector<TimeSpan> gaps;
  double from = span.begin;
  for (const ContactStretch& stretch : open_.all()) {
    if (stretch.begin > from) gaps.push_back({from, std::min(stretch.begin, span.end)});
    from = std::max(from, stretch.end);
  }
  if (from < span.end || (!lasts(span) && !open_.includes(span.begin, span.end))) {
    gaps.push_back({from, span.end});
  }
  for (const TimeSpan& gap : gaps) {
    // Two slabs that are apart in space have nothing inside each other.
    const bool joined = continued && gap.begin == span.begin;
    Result<std::vector<SurfacePart>> ofA;
    Result<std::vector<SurfacePart>> ofB;
    model::together(
        [&] {
          ofA = insideA_.find(a_.slab(), a_.number(), gap, b_.slab(), b_.tree().bounds(), joined);
        },
        [&] {
          ofB = insideB_.find(b_.slab(), b_.number(), gap, a_.slab(), a_.tree().bounds(), joined);
        });
    if (!ofA) return ofA.error();
    if (!ofB) return ofB.error();
    for (const SurfacePart& part : *ofA) addInside(part, a_, /*isA=*/true, span);
    for (const SurfacePart& part : *ofB) addInside(part, b_, /*isA=*/false, span);
  }
  return {};
}

void PairSearch::addInside(const SurfacePart& part, const LoadedSlab& side, bool isA,
                           const TimeSpan& span) {
  ContactStretch stretch;
  stretch.begin = part.begin;
  stretch.end = part.end;
  stretch.overlaps = lasts(span);
  if (stretch.overlaps) stretch.crossing = {part.begin, part.end};
  stretch.beginKnown = stretch.endKnown = true;
  stretch.first.time = part.begin;
  stretch.first.point = pointAt(side.slab(), part.cell, part.begin);
  (isA ? stretch.first.a : stretch.first.b) = CellNumber{side.number(), part.cell};
  stretch.last = stretch.first;
  open_.add(stretch);
}

/// Unites stretches that are apart by rounding only.
void PairSearch::join() {
  ContactStretches joined;
  for (const ContactStretch& stretch : open_.all()) {
    if (!joined.empty() && sameTime(joined.all().back().end, stretch.begin)) {
      joined.all().back().end = stretch.begin;
    }
    joined.add(stretch);
  }
  open_ = std::move(joined);
}

bool PairSearch::isInContact(const SlabWindow& window) const {
  return std::ranges::any_of(intervals_, [&](const ContactInterval& interval) {
    return interval.begin <= window.span.end && interval.end >= window.span.begin;
  });
}

bool PairSearch::mayBeNearest(std::size_t window) const {
  if (isInContact(windows_[window])) return false;
  return options_.clearanceOverTime || apart_[window] <= nearest_.distance;
}

std::size_t PairSearch::nearestByBoxes() const {
  return static_cast<std::size_t>(std::ranges::min_element(apart_) - apart_.begin());
}

void PairSearch::findClearance(std::size_t window) {
  const TimeSpan& span = windows_[window].span;
  if (!mayBeNearest(window)) {
    if (isInContact(windows_[window])) overTime_.push_back({span, 0});
    last_ = nearest_;
    return;
  }
  const WindowSearch search(a_, b_, span);
  Clearance here = options_.clearanceOverTime ? noClearance() : nearest_;
  // The cells that were nearest before are near.
  search.tryCells(static_cast<std::uint32_t>(last_.a.cell),
                  static_cast<std::uint32_t>(last_.b.cell), here);
  search.findNearest(here);
  last_ = here;
  if (options_.clearanceOverTime) overTime_.push_back({span, here.distance});
  here.lowerBound = std::min(here.lowerBound, nearest_.lowerBound);
  if (here.distance < nearest_.distance) nearest_ = here;
  nearest_.lowerBound = here.lowerBound;
}

/// Takes what ends before `time` as final.
void PairSearch::finishBefore(double time) {
  ContactStretches left;
  for (const ContactStretch& stretch : open_.all()) {
    if (stretch.end >= time) {
      left.add(stretch);
      continue;
    }
    ContactInterval interval;
    interval.begin = interval.deepestTime = stretch.begin;
    interval.end = stretch.end;
    interval.first = stretch.first;
    interval.overlaps = stretch.overlaps;
    interval.crossing = stretch.crossing;
    intervals_.push_back(interval);
  }
  open_ = std::move(left);
}

Result<Collision> PairSearch::finish() {
  Collision collision;
  if (windows_.empty()) return collision;
  collision.common = TimeSpan{windows_.front().span.begin, windows_.back().span.end};
  collision.intervals = std::move(intervals_);
  collision.clearanceOverTime = std::move(overTime_);
  if (collision.intervals.empty() && std::isfinite(nearest_.distance)) {
    collision.clearance = nearest_;
  }
  for (ContactInterval& interval : collision.intervals) {
    // Ends of the interval were rounded once.
    TimeSpan& crossing = interval.crossing;
    crossing = {std::max(crossing.begin, interval.begin), std::min(crossing.end, interval.end)};
    if (!lasts(crossing)) crossing = {interval.begin, interval.end};
    interval.deepestTime = std::midpoint(interval.crossing.begin, interval.crossing.end);
  }
  if (options_.overlapVolumes) {
    auto measured = measureOverlaps(a_.source(), b_.source(), collision.intervals);
    if (!measured) return measured.error();
  }
  return collision;
}

}  // namespace t4d::measure
