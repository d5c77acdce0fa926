#include "t4d/measure/components.h"

#include <algorithm>

#include "t4d/model/union_find.h"

namespace t4d::measure {

Components componentsOf(const model::Connectivity& connectivity) {
  model::UnionFind sets(connectivity.vertexCount);
  Components components;
  components.ofVertex.assign(connectivity.vertexCount, kNoComponent);
  for (const model::Cell& cell : connectivity.cells) {
    for (int i = 1; i < 4; ++i) sets.unite(cell[i], cell[0]);
  }
  std::vector<std::uint32_t> number(connectivity.vertexCount, kNoComponent);
  for (const model::Cell& cell : connectivity.cells) {
    std::uint32_t& found = number[sets.root(cell[0])];
    if (found == kNoComponent) found = components.count++;
    for (const std::uint32_t vertex : cell) components.ofVertex[vertex] = found;
  }
  return components;
}

void ComponentCounter::add(const Components& components, std::uint32_t lowerCount,
                           std::uint32_t upperCount) {
  // The components that reach this slab's lower layer, then those of the slab itself.
  model::UnionFind sets(std::size_t{live_} + components.count);
  const std::size_t seam = std::min<std::size_t>(lowerCount, ofLayer_.size());
  for (std::size_t i = 0; i < seam; ++i) {
    if (ofLayer_[i] == kNoComponent || components.ofVertex[i] == kNoComponent) continue;
    sets.unite(ofLayer_[i], live_ + components.ofVertex[i]);
  }
  // A component ends here if the slab does not use its vertices in the lower layer.
  const std::uint32_t total = live_ + components.count;
  std::vector<std::uint32_t> number(total, kNoComponent);
  std::uint32_t newLive = 0;
  const std::size_t firstUpper = components.ofVertex.size() - upperCount;
  std::vector<std::uint32_t> newLayer(upperCount, kNoComponent);
  for (std::uint32_t i = 0; i < upperCount; ++i) {
    const std::uint32_t local = components.ofVertex[firstUpper + i];
    if (local == kNoComponent) continue;
    std::uint32_t& found = number[sets.root(live_ + local)];
    if (found == kNoComponent) found = newLive++;
    newLayer[i] = found;
  }
  for (std::uint32_t i = 0; i < total; ++i) {
    if (sets.root(i) == i && number[i] == kNoComponent) ++finished_;
  }
  live_ = newLive;
  ofLayer_ = std::move(newLayer);
}

}  // namespace t4d::measure
