#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::edit {

/// The two vertices in whose middle a vertex is; a copy of a vertex has it twice.
using VertexOrigin = std::array<std::uint32_t, 2>;

/// The origin of a vertex that is neither a copy of another one nor in the middle of two.
inline constexpr VertexOrigin kNewVertex = {model::kNoIndex, model::kNoIndex};

/// The origins of the vertices of a surface in the making, by the vertices of the given surface.
class VertexLineage {
 public:
  /// Each vertex is its own origin.
  explicit VertexLineage(std::size_t vertices) {
    for (std::uint32_t i = 0; i < vertices; ++i) origins_.push_back({i, i});
  }

  /// The vertices become those that `steps` makes of them.
  void follow(std::span<const VertexOrigin> steps) {
    std::vector<VertexOrigin> origins;
    origins.reserve(steps.size());
    for (const VertexOrigin& step : steps) origins.push_back(through(step));
    origins_ = std::move(origins);
  }

  /// Only these vertices remain, in this order; they may repeat.
  void select(std::span<const std::uint32_t> vertices) {
    std::vector<VertexOrigin> origins;
    origins.reserve(vertices.size());
    for (const std::uint32_t vertex : vertices) origins.push_back(origins_[vertex]);
    origins_ = std::move(origins);
  }

  /// Adds copies of these vertices at the end.
  void append(std::span<const std::uint32_t> copied) {
    for (const std::uint32_t vertex : copied) origins_.push_back(VertexOrigin(origins_[vertex]));
  }

  /// Adds new vertices at the end until there are so many.
  void extend(std::size_t vertices) { origins_.resize(vertices, kNewVertex); }

  std::span<const VertexOrigin> origins() const { return origins_; }

 private:
  VertexOrigin through(const VertexOrigin& step) const {
    if (step[0] == model::kNoIndex) return kNewVertex;
    const VertexOrigin& a = origins_[step[0]];
    const VertexOrigin& b = origins_[step[1]];
    if (a == b) return a;
    if (a[0] == a[1] && b[0] == b[1]) return {a[0], b[0]};
    return kNewVertex;
  }

  std::vector<VertexOrigin> origins_;
};

}  // namespace t4d::edit
