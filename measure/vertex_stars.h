#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// The cells of each vertex.
class VertexStars {
 public:
  explicit VertexStars(const model::Connectivity& connectivity)
      : begin_(std::size_t{connectivity.vertexCount} + 2, 0),
        cells_(4 * connectivity.cells.size()) {
    // Counted two places further on, so that filling moves each begin to where it belongs.
    for (const model::Cell& cell : connectivity.cells) {
      for (const std::uint32_t vertex : cell) ++begin_[vertex + 2];
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    for (std::uint32_t i = 0; i < connectivity.cells.size(); ++i) {
      for (const std::uint32_t vertex : connectivity.cells[i]) cells_[begin_[vertex + 1]++] = i;
    }
  }
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(cells_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> cells_;
};

}  // namespace t4d::measure
