#pragma once

#include <cstdint>
#include <vector>

#include "t4d/model/slab.h"

namespace t4d::measure {

/// Marks a vertex that no cell uses.
inline constexpr std::uint32_t kNoComponent = ~std::uint32_t{0};

/// The connected components of one slab: the vertices of a cell are connected.
struct Components {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> ofVertex;  ///< 0 .. count - 1, or kNoComponent
};

Components componentsOf(const model::Connectivity& connectivity);

/// Counts the connected components of a mesh slab by slab, with one layer in memory.
class ComponentCounter {
 public:
  void add(const Components& components, std::uint32_t lowerCount, std::uint32_t upperCount);
  /// Components so far, including those that reach the last upper layer.
  std::uint64_t count() const { return finished_ + live_; }

 private:
  std::uint64_t finished_ = 0;
  std::uint32_t live_ = 0;              // components that reach the last upper layer
  std::vector<std::uint32_t> ofLayer_;  // component of each vertex of that layer
};

}  // namespace t4d::measure
