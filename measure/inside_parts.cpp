#include "measure/inside_parts.h"

#include <algorithm>
#include <map>
#include <memory>
#include <unordered_map>

#include "measure/winding_number.h"
#include "model/union_find.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::measure {
namespace {

using model::Cell;
using model::Point3;
using model::Point4;
using model::Slab;
using model::TimeSpan;

TimeSpan spanOf(const Slab& slab, const Cell& cell) {
  TimeSpan span{slab.vertices[cell[0]][3], slab.vertices[cell[0]][3]};
  for (const std::uint32_t vertex : cell) {
    span.begin = std::min(span.begin, slab.vertices[vertex][3]);
    span.end = std::max(span.end, slab.vertices[vertex][3]);
  }
  return span;
}

/// Solids at times, each cut once.
class Sections {
 public:
  explicit Sections(const Slab& slab) : slab_(slab) {}

  Result<bool> contains(const Point4& point) {
    const auto [found, added] = at_.try_emplace(point[3]);
    if (added) {
      const bool atEnd = point[3] == slab_.timeEnd;
      slice::Slicer slicer(slice::Hyperplane::atTime(point[3]),
                           atEnd ? slice::OnHyperplane::Above : slice::OnHyperplane::Below);
      if (auto put = slicer.put(slab_); !put) return put.error();
      found->second = slicer.finish().mesh;
    }
    return WindingNumber::exactAt(found->second, point.head<3>()) > 0.5;
  }

 private:
  const Slab& slab_;
  std::map<double, model::TriangleMesh> at_;
};

}  // namespace

Point3 pointAt(const Slab& slab, std::uint32_t cell, double time) {
  const Cell& corners = slab.connectivity->cells[cell];
  const auto [low, high] = std::ranges::minmax(
      corners, {}, [&](std::uint32_t vertex) { return slab.vertices[vertex][3]; });
  const Point4& p = slab.vertices[low];
  const Point4& q = slab.vertices[high];
  if (!(q[3] > p[3]) || time <= p[3]) return p.head<3>();
  if (time >= q[3]) return q.head<3>();
  return (p + (time - p[3]) / (q[3] - p[3]) * (q - p)).head<3>();
}

InsideParts::Parts InsideParts::partsOf(const Slab& slab, const TimeSpan& gap) {
  // What a cell has in the gap is convex, and so connected; with others it is connected by vertices
  // in the gap, and by edges that cross all of it.
  const std::vector<Cell>& cells = slab.connectivity->cells;
  const auto vertexCount = static_cast<std::uint32_t>(slab.vertices.size());
  std::unordered_map<std::uint64_t, std::uint32_t> edges;
  std::vector<std::array<std::uint32_t, 2>> links;
  std::vector<std::uint32_t> nodeOf(cells.size(), model::kNoIndex);
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    const auto join = [&](std::uint32_t node) {
      if (nodeOf[i] == model::kNoIndex) {
        nodeOf[i] = node;
      } else if (nodeOf[i] != node) {
        links.push_back({nodeOf[i], node});
      }
    };
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t p = cells[i][k];
      const double t = slab.vertices[p][3];
      if (t > gap.begin && t < gap.end) join(p);
      for (int l = 0; l < 4 && t <= gap.begin; ++l) {
        const std::uint32_t q = cells[i][l];
        if (slab.vertices[q][3] < gap.end) continue;
        const std::uint64_t key = std::uint64_t{std::min(p, q)} << 32 | std::max(p, q);
        const auto number = vertexCount + static_cast<std::uint32_t>(edges.size());
        join(edges.try_emplace(key, number).first->second);
      }
    }
  }
  model::UnionFind sets(vertexCount + edges.size());
  for (const auto& [p, q] : links) sets.unite(p, q);

  Parts parts;
  parts.ofCell.assign(cells.size(), model::kNoIndex);
  std::unordered_map<std::uint32_t, std::uint32_t> numberOfRoot;
  const double middle = gap.begin + (gap.end - gap.begin) / 2;
  std::vector<std::uint8_t> atMiddle;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (nodeOf[i] == model::kNoIndex) continue;
    const TimeSpan whole = spanOf(slab, cells[i]);
    const TimeSpan span{std::max(whole.begin, gap.begin), std::min(whole.end, gap.end)};
    const auto [found, added] = numberOfRoot.try_emplace(
        sets.root(nodeOf[i]), static_cast<std::uint32_t>(parts.all.size()));
    if (added) {
      parts.all.push_back({span.begin, span.end, i, Point4::Zero()});
      atMiddle.push_back(0);
    }
    const std::uint32_t number = found->second;
    parts.ofCell[i] = number;
    SurfacePart& part = parts.all[number];
    if (span.begin < part.begin) {
      part.begin = span.begin;
      part.cell = i;
    }
    part.end = std::max(part.end, span.end);
    const bool isAtMiddle = span.begin < middle && middle < span.end;
    if (added || (isAtMiddle && atMiddle[number] == 0)) {
      const double time = isAtMiddle ? middle : span.begin + (span.end - span.begin) / 2;
      part.point << pointAt(slab, i, time), time;
      atMiddle[number] = isAtMiddle ? 1 : 0;
    }
  }
  return parts;
}

Result<std::vector<SurfacePart>> InsideParts::find(const Slab& slab, std::uint64_t slabNumber,
                                                   const TimeSpan& gap, const Slab& other,
                                                   const model::Bounds4& boundsOfOther,
                                                   bool joinedToLast) {
  const std::vector<Cell>& cells = slab.connectivity->cells;
  Parts parts = partsOf(slab, gap);
  constexpr std::uint8_t kUnknown = 2;
  std::vector<std::uint8_t> inside(parts.all.size(), kUnknown);
  if (joinedToLast && slabNumber == slabNumber_) {
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
      if (parts.ofCell[i] == model::kNoIndex || parts_.ofCell[i] == model::kNoIndex) continue;
      inside[parts.ofCell[i]] = inside_[parts_.ofCell[i]];
    }
  } else if (joinedToLast && connectivity_ && connectivity_->upperCount > 0) {
    std::vector<std::uint8_t> ofLayer(connectivity_->upperCount, kUnknown);
    for (std::uint32_t i = 0; i < connectivity_->cells.size(); ++i) {
      if (parts_.ofCell[i] == model::kNoIndex) continue;
      for (const std::uint32_t vertex : connectivity_->cells[i]) {
        if (vertex < connectivity_->firstUpper()) continue;
        ofLayer[vertex - connectivity_->firstUpper()] = inside_[parts_.ofCell[i]];
      }
    }
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
      if (parts.ofCell[i] == model::kNoIndex) continue;
      for (const std::uint32_t vertex : cells[i]) {
        if (vertex < ofLayer.size() && ofLayer[vertex] != kUnknown) {
          inside[parts.ofCell[i]] = ofLayer[vertex];
        }
      }
    }
  }
  Sections sections(other);
  std::vector<SurfacePart> found;
  for (std::size_t k = 0; k < parts.all.size(); ++k) {
    if (inside[k] == kUnknown) {
      const Point4& point = parts.all[k].point;
      const bool inBounds = (point.array() >= boundsOfOther.min.array()).all() &&
                            (point.array() <= boundsOfOther.max.array()).all();
      inside[k] = 0;
      if (inBounds) {
        const auto contains = sections.contains(point);
        if (!contains) return contains.error();
        inside[k] = *contains ? 1 : 0;
      }
    }
    if (inside[k] == 1) found.push_back(parts.all[k]);
  }
  parts_ = std::move(parts);
  inside_ = std::move(inside);
  slabNumber_ = slabNumber;
  connectivity_ = slab.connectivity;
  return found;
}

}  // namespace t4d::measure
