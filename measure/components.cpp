#include "measure/components.h"

#include <algorithm>

#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

// Bits of the label of a component that has ended.
constexpr std::uint32_t kEnded = std::uint32_t{1} << 31U;
constexpr std::uint32_t kLastAlone = std::uint32_t{1} << 30U;

}  // namespace

Components componentsOf(const model::Connectivity& connectivity) {
  model::UnionFind sets(connectivity.vertexCount);
  Components components;
  components.ofVertex.assign(connectivity.vertexCount, model::kNoIndex);
  for (const model::Cell& cell : connectivity.cells) {
    for (int i = 1; i < 4; ++i) sets.unite(cell[i], cell[0]);
  }
  std::vector<std::uint32_t> number(connectivity.vertexCount, model::kNoIndex);
  for (const model::Cell& cell : connectivity.cells) {
    std::uint32_t& found = number[sets.root(cell[0])];
    if (found == model::kNoIndex) found = components.count++;
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
    if (ofLayer_[i] == model::kNoIndex || components.ofVertex[i] == model::kNoIndex) continue;
    sets.unite(ofLayer_[i], live_ + components.ofVertex[i]);
  }
  // A component ends here if the slab does not use its vertices in the lower layer.
  const std::uint32_t total = live_ + components.count;
  std::vector<std::uint32_t> number(total, model::kNoIndex);
  std::uint32_t newLive = 0;
  const std::size_t firstUpper = components.ofVertex.size() - upperCount;
  std::vector<std::uint32_t> newLayer(upperCount, model::kNoIndex);
  for (std::uint32_t i = 0; i < upperCount; ++i) {
    const std::uint32_t local = components.ofVertex[firstUpper + i];
    if (local == model::kNoIndex) continue;
    std::uint32_t& found = number[sets.root(live_ + local)];
    if (found == model::kNoIndex) found = newLive++;
    newLayer[i] = found;
  }
  for (std::uint32_t i = 0; i < total; ++i) {
    if (sets.root(i) == i && number[i] == model::kNoIndex) ++finished_;
  }
  if (tracks_) {
    std::vector<std::uint32_t> roots(total);
    for (std::uint32_t i = 0; i < total; ++i) roots[i] = sets.root(i);
    track(components.count, roots, number);
  }
  live_ = newLive;
  ofLayer_ = std::move(newLayer);
}

/// `roots` are of the components live before and then those `ofSlab`; `live` is the number of a
/// root from now on, if it has one.
void ComponentCounter::track(std::uint32_t ofSlab, const std::vector<std::uint32_t>& roots,
                             const std::vector<std::uint32_t>& live) {
  if (!begun_) {
    firsts_.resize(ofSlab);
    for (std::uint32_t i = 0; i < ofSlab; ++i) firsts_[i] = live_ + i;
    begun_ = true;
  }
  std::vector<std::uint32_t> ended(roots.size(), model::kNoIndex);
  for (std::uint32_t& first : firsts_) {
    if ((first & kEnded) != 0) continue;
    const std::uint32_t root = roots[first];
    if (live[root] == model::kNoIndex && ended[root] == model::kNoIndex) {
      ended[root] = kEnded | endedFirsts_++;
      --finished_;
    }
    first = live[root] != model::kNoIndex ? live[root] : ended[root];
  }
  endedLasts_ = 0;
  lasts_.resize(ofSlab);
  for (std::uint32_t i = 0; i < ofSlab; ++i) {
    const std::uint32_t root = roots[live_ + i];
    if (live[root] == model::kNoIndex && ended[root] == model::kNoIndex) {
      ended[root] = kEnded | kLastAlone | endedLasts_++;
    }
    lasts_[i] = live[root] != model::kNoIndex ? live[root] : ended[root];
  }
}

std::uint32_t ComponentCounter::classOf(std::uint32_t label) const {
  const std::uint32_t number = label & ~(kEnded | kLastAlone);
  if ((label & kEnded) == 0) return number;
  return live_ + number + ((label & kLastAlone) != 0 ? endedFirsts_ : 0);
}

ComponentSpan ComponentCounter::span() const {
  ComponentSpan span;
  span.inside = finished_ - endedLasts_;
  span.classes = live_ + endedFirsts_ + endedLasts_;
  for (const std::uint32_t label : firsts_) span.ofFirst.push_back(classOf(label));
  for (const std::uint32_t label : lasts_) span.ofLast.push_back(classOf(label));
  return span;
}

bool countComponents(const std::vector<ComponentSpan>& spans, std::uint64_t& count) {
  std::vector<std::size_t> firstClass(spans.size() + 1);
  count = 0;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    firstClass[i + 1] = firstClass[i] + spans[i].classes;
    count += spans[i].inside;
  }
  model::UnionFind sets(firstClass.back());
  for (std::size_t i = 0; i + 1 < spans.size(); ++i) {
    const auto& last = spans[i].ofLast;
    const auto& next = spans[i + 1].ofFirst;
    if (last.size() != next.size()) return false;
    for (std::size_t k = 0; k < last.size(); ++k) {
      if (last[k] >= spans[i].classes || next[k] >= spans[i + 1].classes) return false;
      sets.unite(static_cast<std::uint32_t>(firstClass[i] + last[k]),
                 static_cast<std::uint32_t>(firstClass[i + 1] + next[k]));
    }
  }
  for (std::uint32_t i = 0; i < firstClass.back(); ++i) count += sets.root(i) == i ? 1 : 0;
  return true;
}

}  // namespace t4d::measure
