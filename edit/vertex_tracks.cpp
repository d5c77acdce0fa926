#include "edit/vertex_tracks.h"

#include <algorithm>

#include <fmt/format.h>

#include "model/facets.h"
#include "model/progress.h"

namespace t4d::edit {
namespace {

using model::Facet;
using model::Triangle;

constexpr const char* kWhy =
    "only a body that keeps its triangles can give way, as one that was swept, not woven; this one";

/// The triangles of the solid at the layer with these facets, which the cells above (`above`) or
/// below it have. Empty if a facet has not exactly one cell.
std::vector<Triangle> trianglesOf(const std::vector<Facet>& facets, bool above) {
  std::vector<Triangle> triangles;
  triangles.reserve(facets.size());
  for (const Facet& facet : facets) {
    if (facet.even + facet.odd == 2 && facet.isMatched()) continue;
    if (facet.even + facet.odd != 1) return {};
    Triangle triangle = facet.vertices;
    if ((facet.even == 1) == above) std::swap(triangle[1], triangle[2]);
    triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace

Result<VertexTracks> VertexTracks::of(const model::Source& source,
                                      const model::Progress& progress) {
  VertexTracks tracks;
  tracks.source_ = &source;
  const std::size_t count = source.slabCount();
  std::shared_ptr<const model::Connectivity> known;
  for (std::size_t i = 0; i < count; ++i) {
    const auto no = [&](const std::string& why) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("{} {} (at time {})", kWhy, why, source.timeSpan(i).begin));
    };
    const model::TimeSpan time = source.timeSpan(i);
    if (!(time.begin < time.end)) {
      if (i > 0 && i + 1 < count) return no("begins or ends in the middle");
      continue;
    }
    if (tracks.steps_ == 0) tracks.firstStep_ = i;
    if (tracks.steps_ > 0 && source.timeSpan(i - 1).end != time.begin) {
      return no("has a gap in time");
    }
    ++tracks.steps_;
    const auto slab = source.slab(i);
    if (!slab) return slab.error();
    const auto& connectivity = (*slab)->connectivity;
    if (connectivity != known) {
      if (auto good = model::checkConnectivity(*connectivity); !good) return good.error();
      if (connectivity->lowerCount != connectivity->upperCount) {
        return no("gets other vertices from layer to layer");
      }
      if (connectivity->firstMean() != connectivity->lowerCount) {
        return no("has vertices between its layers that are not means of those of layers");
      }
      const model::FacetTopology facets = model::facetTopology(*connectivity);
      auto below = trianglesOf(facets.lower, true);
      const auto above = trianglesOf(facets.upper, false);
      if (below.empty() || below != above) {
        return no("has other triangles from layer to layer");
      }
      if (known == nullptr) {
        tracks.triangles_ = std::move(below);
        tracks.vertexCount_ = connectivity->lowerCount;
      } else if (below != tracks.triangles_) {
        return no("changes its triangles");
      }
      known = connectivity;
    }
    if (auto on = model::report(progress, i + 1, count); !on) return on.error();
  }
  if (tracks.steps_ == 0) {
    return fail(ErrorCode::Unsupported, fmt::format("{} does not last", kWhy));
  }
  return tracks;
}

double VertexTracks::layerTime(std::size_t step) const {
  return step < steps_ ? source_->timeSpan(firstStep_ + step).begin
                       : source_->timeSpan(firstStep_ + steps_ - 1).end;
}

Result<std::vector<model::Point3>> VertexTracks::layer(std::size_t step) const {
  const bool last = step == steps_;
  const auto slab = source_->slab(firstStep_ + step - (last ? 1 : 0));
  if (!slab) return slab.error();
  std::vector<model::Point3> points;
  points.reserve(vertexCount_);
  for (const model::Point4& vertex : last ? (*slab)->upperLayer() : (*slab)->lowerLayer()) {
    points.push_back(vertex.head<3>());
  }
  return points;
}

}  // namespace t4d::edit
