#include "edit/clip_time.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "edit/split_cells.h"
#include "model/attribute_rows.h"
#include "model/progress.h"

namespace t4d::edit {
namespace {

using model::Attribute;
using model::Cell;
using model::Connectivity;
using model::Domain;
using model::Point4;
using model::Slab;
using model::TimeSpan;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The part of one slab within a span that it reaches over.
class ClippedSlab {
 public:
  ClippedSlab(const Slab& slab, const TimeSpan& span)
      : slab_(slab),
        whole_(*slab.connectivity),
        begin_(slab.timeBegin < span.begin ? span.begin : -kInfinity),
        end_(slab.timeEnd > span.end ? span.end : kInfinity),
        vertices_(slab.vertices),
        splitter_(vertices_) {}

  Result<Slab> make() {
    if (auto split = splitCells(); !split) return split.error();
    chooseVertices();
    Slab part;
    part.timeBegin = std::max(slab_.timeBegin, begin_);
    part.timeEnd = std::min(slab_.timeEnd, end_);
    part.vertices.reserve(chosen_.size());
    for (const std::uint32_t vertex : chosen_) part.vertices.push_back(vertices_[vertex]);
    auto connectivity = std::make_shared<Connectivity>();
    connectivity->vertexCount = static_cast<std::uint32_t>(chosen_.size());
    connectivity->lowerCount = lowerCount_;
    connectivity->upperCount = upperCount_;
    connectivity->cells = std::move(cells_);
    for (const Attribute& attribute : whole_.cellAttributes) {
      connectivity->cellAttributes.push_back(ofCells(attribute));
    }
    for (const Attribute& attribute : slab_.attributes) {
      part.attributes.push_back(attribute.domain == Domain::Cell ? ofCells(attribute)
                                                                 : ofVertices(attribute));
    }
    part.connectivity = std::move(connectivity);
    return part;
  }

 private:
  /// Keeps the cells and parts of cells within the span. A cell at one time belongs to what lies
  /// before.
  Result<void> splitCells() {
    const auto reachesOver = [](const TimeSpan& times, double time) {
      return times.begin < time && times.end > time;
    };
    const auto isSplit = [&](const Cell& cell) {
      const TimeSpan times = timesOf(slab_.vertices, cell);
      return reachesOver(times, begin_) || reachesOver(times, end_);
    };
    if (auto good = checkNoTwins(whole_.cells, isSplit); !good) return good;
    std::vector<Cell> rest;
    std::vector<Cell> dropped;
    for (std::uint32_t i = 0; i < whole_.cells.size(); ++i) {
      rest.clear();
      const TimeSpan times = timesOf(slab_.vertices, whole_.cells[i]);
      if (reachesOver(times, begin_)) {
        splitter_.split(whole_.cells[i], begin_, dropped, rest);
      } else if (times.end > begin_) {
        rest.push_back(whole_.cells[i]);
      }
      for (const Cell& cell : rest) {
        const TimeSpan left = timesOf(vertices_, cell);
        if (reachesOver(left, end_)) {
          splitter_.split(cell, end_, cells_, dropped);
        } else if (left.begin < end_) {
          cells_.push_back(cell);
        }
      }
      cellOf_.resize(cells_.size(), i);
    }
    return {};
  }

  /// Layers that the slab keeps, whole, and vertices of the cells that are left; a new layer has
  /// those at its time. Numbers the cells anew.
  void chooseVertices() {
    std::vector<std::uint32_t> lower;
    std::vector<std::uint32_t> inside;
    std::vector<std::uint32_t> upper;
    std::vector<bool> isChosen(vertices_.size());
    const auto choose = [&](std::uint32_t vertex, std::vector<std::uint32_t>& into) {
      if (isChosen[vertex]) return;
      isChosen[vertex] = true;
      into.push_back(vertex);
    };
    if (begin_ == -kInfinity) {
      for (std::uint32_t i = 0; i < whole_.lowerCount; ++i) choose(i, lower);
    }
    if (end_ == kInfinity) {
      for (std::uint32_t i = whole_.firstUpper(); i < whole_.vertexCount; ++i) choose(i, upper);
    }
    for (const Cell& cell : cells_) {
      for (const std::uint32_t corner : cell) {
        const double time = vertices_[corner][3];
        choose(corner, time == begin_ ? lower : time == end_ ? upper : inside);
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

  Attribute ofCells(const Attribute& attribute) const { return rowsOf(attribute, cellOf_); }

  Attribute ofVertices(const Attribute& attribute) const {
    return rowsOf(splitter_.withNewRows(attribute), chosen_);
  }

  const Slab& slab_;
  const Connectivity& whole_;
  double begin_;  // where the slab is cut; -infinity if it is not
  double end_;
  std::vector<Point4> vertices_;  // of the slab, then new ones
  CellSplitter splitter_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> cellOf_;  // for each of them, the cell of the slab
  std::vector<std::uint32_t> chosen_;
  std::uint32_t lowerCount_ = 0;
  std::uint32_t upperCount_ = 0;
};

}  // namespace

Result<TimeClip> clipTime(const model::Source& source, const TimeSpan& span, model::Sink& sink,
                          const model::Progress& progress) {
  TimeClip clip;
  RunCloser closer(sink);
  const TimeSpan whole = model::timeSpanOf(source);
  for (std::size_t i = 0; i < source.slabCount(); ++i) {
    const TimeSpan times = source.timeSpan(i);
    const bool isFlat = times.begin == times.end;
    if (isFlat ? times.end < span.begin || times.begin > span.end
               : times.end <= span.begin || times.begin >= span.end) {
      continue;
    }
    const auto slab = source.slab(i);
    if (!slab) return slab.error();
    // A run that ends where the span begins is no part of it, nor is one that begins at its end.
    if (isFlat && times.begin == span.begin && span.begin > whole.begin &&
        (*slab)->connectivity->upperCount == 0) {
      continue;
    }
    if (isFlat && times.begin == span.end && span.end < whole.end &&
        (*slab)->connectivity->lowerCount == 0) {
      continue;
    }
    ++clip.slabs;
    if (times.begin >= span.begin && times.end <= span.end) {
      clip.cells += (*slab)->connectivity->cells.size();
      if (auto put = closer.put(**slab); !put) return put.error();
    } else {
      ++clip.cutSlabs;
      auto part = ClippedSlab(**slab, span).make();
      if (!part) return part.error();
      clip.cells += part->connectivity->cells.size();
      if (auto put = closer.put(*part); !put) return put.error();
    }
    if (auto on = model::report(progress, i + 1, source.slabCount()); !on) return on.error();
  }
  auto caps = closer.finish();
  if (!caps) return caps.error();
  for (const RunEnd& end : *caps) {
    if (end.open) {
      return invalid(fmt::format("the mesh is open at time {} and cannot be closed there: {}",
                                 end.time, *end.open),
                     {}, Remedy::OpenMesh);
    }
  }
  clip.caps = std::move(*caps);
  return clip;
}

}  // namespace t4d::edit
