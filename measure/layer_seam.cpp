#include "measure/layer_seam.h"

#include <algorithm>
#include <utility>

#include "model/union_find.h"

namespace t4d::measure {

using model::kNoIndex;

void LayerSeam::keep(const model::Slab& slab, const SlabReeb& reeb,
                     std::vector<Transition> transitions, std::span<const std::uint32_t> nodes) {
  time_ = slab.timeEnd;
  std::vector<std::uint32_t> numberOf(reeb.nodes.size(), kNoIndex);
  for (std::uint32_t i = 0; i < nodes.size(); ++i) numberOf[nodes[i]] = i;
  pending_ = std::move(transitions);
  ofVertex_.assign(reeb.nodeOfUpper.size(), kNoIndex);
  for (std::size_t k = 0; k < reeb.nodeOfUpper.size(); ++k) {
    const std::uint32_t node = reeb.nodeOfUpper[k];
    if (node == kNoIndex) continue;
    Transition& into = pending_[numberOf[node]];
    ofVertex_[k] = numberOf[node];
    into.placeSum += slab.upperLayer()[k].head<3>();
    ++into.placeCount;
  }
}

std::vector<Transition> LayerSeam::join(const model::Slab& slab, const SlabReeb& reeb) {
  time_ = slab.timeEnd;
  const auto waiting = static_cast<std::uint32_t>(pending_.size());
  std::vector<std::uint32_t> nodes;  // of the first instant
  std::vector<std::uint32_t> itemOfNode(reeb.nodes.size(), kNoIndex);
  for (std::uint32_t n = 0; n < reeb.nodes.size(); ++n) {
    if (reeb.nodes[n].instant != 0) continue;
    itemOfNode[n] = waiting + static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(n);
  }
  model::UnionFind sets(waiting + nodes.size());
  const std::size_t seam = std::min(ofVertex_.size(), reeb.nodeOfLower.size());
  for (std::size_t i = 0; i < seam; ++i) {
    const std::uint32_t node = reeb.nodeOfLower[i];
    if (ofVertex_[i] != kNoIndex && node != kNoIndex) {
      sets.unite(ofVertex_[i], itemOfNode[node]);
    }
  }
  std::vector<Transition> joined;
  std::vector<std::uint32_t> number(waiting + nodes.size());
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    const std::uint32_t root = sets.root(i);
    number[i] = root == i ? static_cast<std::uint32_t>(joined.size()) : number[root];
    if (root == i) joined.emplace_back();
    Transition& into = joined[number[i]];
    if (i < waiting) {
      const Transition& from = pending_[i];
      into.shellsBelow.insert(into.shellsBelow.end(), from.shellsBelow.begin(),
                              from.shellsBelow.end());
      into.change2 += from.change2;
      into.placeSum += from.placeSum;
      into.placeCount += from.placeCount;
    } else {
      const std::uint32_t node = nodes[i - waiting];
      into.change2 += reeb.nodes[node].eulerChange2;
      into.node = node;
    }
  }
  for (std::uint32_t a = 0; a < reeb.arcs.size(); ++a) {
    const std::uint32_t node = reeb.arcs[a].below;
    if (node != kNoIndex && itemOfNode[node] != kNoIndex) {
      joined[number[itemOfNode[node]]].arcsAbove.push_back(a);
    }
  }
  // The places of vertices of this layer that no slab before has given.
  for (std::size_t i = 0; i < reeb.nodeOfLower.size(); ++i) {
    const std::uint32_t node = reeb.nodeOfLower[i];
    if (node == kNoIndex || (i < seam && ofVertex_[i] != kNoIndex)) continue;
    Transition& into = joined[number[itemOfNode[node]]];
    into.placeSum += slab.vertices[i].head<3>();
    ++into.placeCount;
  }
  pending_.clear();
  ofVertex_.clear();
  if (slab.timeBegin < slab.timeEnd) return joined;
  // Nothing goes on before a slab that has a duration.
  ofVertex_.assign(reeb.nodeOfUpper.size(), kNoIndex);
  for (std::size_t i = 0; i < reeb.nodeOfUpper.size(); ++i) {
    const std::uint32_t node = reeb.nodeOfUpper[i];
    if (node == kNoIndex) continue;
    ofVertex_[i] = number[itemOfNode[node]];
    if (!reeb.nodeOfLower.empty()) continue;
    Transition& into = joined[ofVertex_[i]];
    into.placeSum += slab.upperLayer()[i].head<3>();
    ++into.placeCount;
  }
  pending_ = std::move(joined);
  return {};
}

std::vector<Transition> LayerSeam::take() {
  ofVertex_.clear();
  return std::exchange(pending_, {});
}

}  // namespace t4d::measure
