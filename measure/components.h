#pragma once

#include <cstdint>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// Marks a vertex that no cell uses.

/// The connected components of one slab: the vertices of a cell are connected.
struct Components {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> ofVertex;  ///< 0 .. count - 1, or model::kNoIndex
};

Components componentsOf(const model::Connectivity& connectivity);

/// The components of some consecutive slabs, to be joined with those of the slabs before and after.
/// Each of the first slab and of the last one belongs to a class, of which there are `classes`;
/// `inside` reach neither.
struct ComponentSpan {
  std::uint64_t inside = 0;
  std::uint32_t classes = 0;
  std::vector<std::uint32_t> ofFirst;  ///< the class of each component of the first slab
  std::vector<std::uint32_t> ofLast;
};

/// The components of all of these spans together, where the last slab of each is the first slab of
/// the next. Fails (false) if these do not have as many components.
bool countComponents(const std::vector<ComponentSpan>& spans, std::uint64_t& count);

/// Counts the connected components of a mesh slab by slab, with one layer in memory.
class ComponentCounter {
 public:
  void add(const Components& components, std::uint32_t lowerCount, std::uint32_t upperCount);
  /// Components so far, including those that reach the last upper layer.
  std::uint64_t count() const { return finished_ + endedFirsts_ + live_; }

  /// Tracks components for `span` from the next slab on, which is the first of a part.
  void trackSpan() { tracks_ = true; }
  ComponentSpan span() const;

 private:
  void track(std::uint32_t ofSlab, const std::vector<std::uint32_t>& roots,
             const std::vector<std::uint32_t>& live);
  std::uint32_t classOf(std::uint32_t label) const;

  std::uint64_t finished_ = 0;
  std::uint32_t live_ = 0;              // components that reach the last upper layer
  std::vector<std::uint32_t> ofLayer_;  // component of each vertex of that layer

  // Labels of components of the first and the last slab: a live one, or one that has ended.
  bool tracks_ = false;
  bool begun_ = false;
  std::uint32_t endedFirsts_ = 0;  // with one of the first slab, not in finished_
  std::uint32_t endedLasts_ = 0;   // with one of the last slab alone, in finished_
  std::vector<std::uint32_t> firsts_;
  std::vector<std::uint32_t> lasts_;
};

}  // namespace t4d::measure
