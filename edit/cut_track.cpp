#include "edit/cut_track.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "edit/separate_touching.h"
#include "edit/split_cells.h"
#include "measure/vertex_stars.h"
#include "model/attribute_rows.h"
#include "t4d/check.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Cell;
using model::Connectivity;
using model::Domain;
using model::Point4;
using model::Slab;
using model::TimeSpan;

constexpr double kForever = std::numeric_limits<double>::infinity();

/// A slab, and which of its cells are of the track.
class TrackSlab {
 public:
  explicit TrackSlab(const Slab& slab)
      : slab_(slab), stars_(*slab_.connectivity), isOfTrack_(slab_.connectivity->cells.size(), 0) {}

  const Slab& slab() const { return slab_; }
  bool isFlat() const { return slab_.timeBegin == slab_.timeEnd; }

  /// Adds all cells that are connected with these within `life` by cells that share an edge then.
  void add(std::vector<std::uint32_t> cells, const TimeSpan& life) {
    std::erase_if(cells, [&](std::uint32_t cell) { return isOfTrack_[cell] != 0; });
    for (const std::uint32_t cell : cells) isOfTrack_[cell] = 1;
    const auto timeOf = [&](std::uint32_t v) { return slab_.vertices[v][3]; };
    while (!cells.empty()) {
      const Cell cell = slab_.connectivity->cells[cells.back()];
      cells.pop_back();
      for (const std::uint32_t u : cell) {
        for (const std::uint32_t next : stars_.of(u)) {
          if (isOfTrack_[next] != 0) continue;
          const auto isShared = [&](std::uint32_t w) {
            return w != u && std::max(timeOf(u), timeOf(w)) > life.begin &&
                   std::min(timeOf(u), timeOf(w)) < life.end &&
                   std::ranges::find(cell, w) != cell.end();
          };
          if (std::ranges::none_of(slab_.connectivity->cells[next], isShared)) continue;
          isOfTrack_[next] = 1;
          cells.push_back(next);
        }
      }
    }
  }

  /// Adds all cells around some vertices of a layer, numbered from its first one, which are of the
  /// track.
  void addAround(const std::vector<std::uint32_t>& layer, bool lower, const TimeSpan& life) {
    std::vector<std::uint32_t> cells;
    for (const std::uint32_t vertex : layer) {
      const auto star = stars_.of(vertex + (lower ? 0 : slab_.connectivity->firstUpper()));
      cells.insert(cells.end(), star.begin(), star.end());
    }
    add(std::move(cells), life);
  }

  /// The vertices of a layer that cells of the track have, numbered from its first one.
  std::vector<std::uint32_t> ofLayer(bool lower) const {
    const Connectivity& connectivity = *slab_.connectivity;
    const std::uint32_t first = lower ? 0 : connectivity.firstUpper();
    const std::uint32_t count = lower ? connectivity.lowerCount : connectivity.upperCount;
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto isOfTrack = [&](std::uint32_t cell) { return isOfTrack_[cell] != 0; };
      if (std::ranges::any_of(stars_.of(first + i), isOfTrack)) vertices.push_back(i);
    }
    return vertices;
  }

  bool isWhole() const {
    return std::ranges::all_of(isOfTrack_, [](char isOf) { return isOf != 0; });
  }
  bool isOfTrack(std::uint32_t cell) const { return isOfTrack_[cell] != 0; }

 private:
  Slab slab_;
  measure::VertexStars stars_;
  std::vector<char> isOfTrack_;
};

/// The part of a slab that is of the track, within its life.
class TrackPiece {
 public:
  TrackPiece(const TrackSlab& from, const TimeSpan& life)
      : from_(from),
        slab_(from.slab()),
        whole_(*slab_.connectivity),
        life_(life),
        vertices_(slab_.vertices),
        splitter_(vertices_) {}

  bool begins() const { return life_.begin >= slab_.timeBegin; }
  bool ends() const { return life_.end <= slab_.timeEnd; }
  bool isCut() const { return life_.begin > slab_.timeBegin || life_.end < slab_.timeEnd; }

  /// `lower` and `upper`: the vertices of layers, where the track goes on.
  Result<Slab> make(const std::vector<std::uint32_t>& lower,
                    const std::vector<std::uint32_t>& upper) {
    if (auto split = splitCells(); !split) return split.error();
    if (begins()) separateTouching(life_.begin, vertices_, splitter_, cells_, cellOf_);
    if (ends()) separateTouching(life_.end, vertices_, splitter_, cells_, cellOf_);
    chooseVertices(lower, upper);
    Slab part;
    part.timeBegin = std::max(slab_.timeBegin, life_.begin);
    part.timeEnd = std::min(slab_.timeEnd, life_.end);
    part.vertices.reserve(chosen_.size());
    for (const std::uint32_t vertex : chosen_) part.vertices.push_back(vertices_[vertex]);
    auto connectivity = std::make_shared<Connectivity>();
    connectivity->vertexCount = static_cast<std::uint32_t>(chosen_.size());
    connectivity->lowerCount = lowerCount_;
    connectivity->upperCount = upperCount_;
    connectivity->cells = std::move(cells_);
    for (const Attribute& attribute : whole_.cellAttributes) {
      connectivity->cellAttributes.push_back(rowsOf(attribute, cellOf_));
    }
    for (const Attribute& attribute : slab_.attributes) {
      part.attributes.push_back(attribute.domain == Domain::Cell
                                    ? rowsOf(attribute, cellOf_)
                                    : rowsOf(splitter_.withNewRows(attribute), chosen_));
    }
    part.connectivity = std::move(connectivity);
    return part;
  }

 private:
  Result<void> splitCells() {
    const auto reachesOver = [](const TimeSpan& times, double time) {
      return times.begin < time && times.end > time;
    };
    std::vector<Cell> ofTrack;
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < whole_.cells.size(); ++i) {
      if (!from_.isOfTrack(i)) continue;
      ofTrack.push_back(whole_.cells[i]);
      numbers.push_back(i);
    }
    const auto isSplit = [&](const Cell& cell) {
      const TimeSpan times = timesOf(slab_.vertices, cell);
      return reachesOver(times, life_.begin) || reachesOver(times, life_.end);
    };
    if (auto good = checkNoTwins(ofTrack, isSplit); !good) return good;
    std::vector<Cell> rest;
    std::vector<Cell> dropped;
    for (std::size_t i = 0; i < ofTrack.size(); ++i) {
      rest.clear();
      if (reachesOver(timesOf(slab_.vertices, ofTrack[i]), life_.begin)) {
        splitter_.split(ofTrack[i], life_.begin, dropped, rest);
      } else {
        rest.push_back(ofTrack[i]);
      }
      for (const Cell& cell : rest) {
        const TimeSpan left = timesOf(vertices_, cell);
        if (reachesOver(left, life_.end)) {
          splitter_.split(cell, life_.end, cells_, dropped);
        } else if (left.begin < life_.end) {
          cells_.push_back(cell);
        }
      }
      cellOf_.resize(cells_.size(), numbers[i]);
    }
    return {};
  }

  /// Layers where the track goes on, and vertices of its cells. Numbers the cells anew.
  void chooseVertices(const std::vector<std::uint32_t>& lowerLayer,
                      const std::vector<std::uint32_t>& upperLayer) {
    std::vector<std::uint32_t> lower;
    std::vector<std::uint32_t> inside;
    std::vector<std::uint32_t> upper;
    std::vector<char> isChosen(vertices_.size(), 0);
    const auto choose = [&](std::uint32_t vertex, std::vector<std::uint32_t>& into) {
      if (isChosen[vertex] != 0) return;
      isChosen[vertex] = 1;
      into.push_back(vertex);
    };
    if (!begins()) {
      for (const std::uint32_t i : lowerLayer) choose(i, lower);
    }
    if (!ends()) {
      for (const std::uint32_t i : upperLayer) choose(whole_.firstUpper() + i, upper);
    }
    for (const Cell& cell : cells_) {
      for (const std::uint32_t corner : cell) {
        const double time = vertices_[corner][3];
        choose(corner, begins() && time == life_.begin ? lower
                       : ends() && time == life_.end   ? upper
                                                       : inside);
      }
    }
    lowerCount_ = static_cast<std::uint32_t>(lower.size());
    upperCount_ = static_cast<std::uint32_t>(upper.size());
    std::vector<std::uint32_t> number(vertices_.size());
    for (auto* some : {&lower, &inside, &upper}) {
      std::ranges::sort(*some);
      for (const std::uint32_t vertex : *some) {
        number[vertex] = static_cast<std::uint32_t>(chosen_.size());
        chosen_.push_back(vertex);
      }
    }
    for (Cell& cell : cells_) {
      for (std::uint32_t& corner : cell) corner = number[corner];
    }
  }

  const TrackSlab& from_;
  const Slab& slab_;
  const Connectivity& whole_;
  TimeSpan life_;
  std::vector<Point4> vertices_;  // of the slab, then new ones
  CellSplitter splitter_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> cellOf_;  // for each of them, the cell of the slab
  std::vector<std::uint32_t> chosen_;
  std::uint32_t lowerCount_ = 0;
  std::uint32_t upperCount_ = 0;
};

class TrackCutter : public model::Sink {
 public:
  TrackCutter(const TimeSpan& time, std::uint32_t track, model::Sink& sink)
      : tracker_(time, {}, /*surfaces=*/false), track_(track), closer_(sink) {
    tracker_.follow(track);
  }

  Result<void> put(const Slab& slab) override { return putPrepared(slab, prepare(slab).get()); }
  std::unique_ptr<Prepared> prepare(const Slab& slab) const override {
    return done_ ? nullptr : tracker_.prepare(slab);
  }
  Result<void> putPrepared(const Slab& slab, Prepared* prepared) override {
    if (done_) return {};
    if (auto put = tracker_.putPrepared(slab, prepared); !put) return put;
    const measure::FollowedTrack& track = tracker_.followed();
    if (slab.timeBegin == slab.timeEnd) {
      // Whether the track goes on through it is known after the next slab.
      if (!held_.empty()) held_.push_back(std::make_unique<TrackSlab>(slab));
      return {};
    }
    const bool endedBefore = track.ended && track.end <= slab.timeBegin;
    if (endedBefore) return putHeld();
    if (!track.begun || track.cells.empty()) return {};
    auto next = std::make_unique<TrackSlab>(slab);
    // Cells within the last layer are of the track if that goes on there.
    next->add(track.cells, {track.begin, track.ended ? track.end : slab.timeEnd});
    held_.push_back(std::move(next));
    while (held_.size() > 1) {
      if (auto put = putFirst(); !put) return put;
    }
    return track.ended ? putHeld() : Result<void>();
  }

  Result<TrackCut> finish() {
    const measure::Tracks tracks = tracker_.finish();
    if (!tracker_.followed().begun) {
      return invalid(fmt::format("has no track {}; it has {}", track_ + 1, tracks.tracks.size()));
    }
    if (auto put = putHeld(); !put) return put.error();
    auto caps = closer_.finish();
    if (!caps) return caps.error();
    for (const RunEnd& end : *caps) {
      if (!end.open) continue;
      return invalid(fmt::format("the track is open at time {} and cannot be closed there: {}",
                                 end.time, *end.open),
                     {}, Remedy::OpenMesh);
    }
    cut_.span = {tracker_.followed().begin, tracker_.followed().end};
    cut_.caps = std::move(*caps);
    return std::move(cut_);
  }

 private:
  /// The track ends in the first slab that is held, or at its end.
  Result<void> putHeld() {
    if (!done_ && !held_.empty()) {
      held_.resize(1);
      if (auto put = putFirst(); !put) return put;
    }
    done_ = tracker_.followed().begun;
    return {};
  }

  Result<void> putFirst() {
    TrackSlab& slab = *held_.front();
    const measure::FollowedTrack& track = tracker_.followed();
    const TimeSpan life{track.begin, track.ended ? track.end : kForever};
    std::vector<std::uint32_t> upper;
    if (held_.size() > 1) {
      TrackSlab& next = *held_[1];
      slab.addAround(next.ofLayer(/*lower=*/true), /*lower=*/false, life);
      upper = slab.ofLayer(/*lower=*/false);
      next.addAround(upper, /*lower=*/true, life);
      upper = next.ofLayer(/*lower=*/true);
    }
    TrackPiece piece(slab, life);
    ++cut_.slabs;
    if (piece.isCut()) ++cut_.cutSlabs;
    const Connectivity& whole = *slab.slab().connectivity;
    Result<void> put;
    if (slab.isWhole() && !piece.begins() && !piece.ends() && lower_.size() == whole.lowerCount &&
        upper.size() == whole.upperCount) {
      cut_.cells += whole.cells.size();
      put = closer_.put(slab.slab());
    } else {
      auto made = piece.make(lower_, upper);
      if (!made) return made.error();
      // Slabs with one connectivity keep one.
      if (recent_ && *recent_ == *made->connectivity) made->connectivity = recent_;
      recent_ = made->connectivity;
      cut_.cells += made->connectivity->cells.size();
      put = closer_.put(*made);
    }
    lower_ = std::move(upper);
    held_.erase(held_.begin());
    return put;
  }

  measure::Tracker tracker_;
  std::uint32_t track_;
  RunCloser closer_;
  TrackCut cut_;
  std::vector<std::unique_ptr<TrackSlab>> held_;
  std::shared_ptr<const Connectivity> recent_;
  std::vector<std::uint32_t> lower_;  // vertices of the layer that was put last
  std::atomic<bool> done_ = false;
};

}  // namespace

Result<TrackCut> cutTrack(const model::Source& source, std::uint32_t track, model::Sink& sink,
                          const model::Progress& progress) {
  TrackCutter cutter(model::timeSpanOf(source), track, sink);
  if (auto read = model::pump(source, cutter, progress); !read) return read.error();
  return cutter.finish();
}

}  // namespace t4d::edit
