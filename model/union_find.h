#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace t4d::model {

/// Disjoint sets of the items 0 .. size - 1, initially singletons.
class UnionFind {
 public:
  explicit UnionFind(std::size_t size = 0) { reset(size); }

  void reset(std::size_t size) {
    parent_.resize(size);
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  /// The smallest item in the set of `item`.
  std::uint32_t root(std::uint32_t item) {
    while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
    return item;
  }

  /// Merges the sets of two items. False if they were already the same.
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a > b) std::swap(a, b);
    parent_[b] = a;
    return a != b;
  }

 private:
  std::vector<std::uint32_t> parent_;  // never larger than the item
};

}  // namespace t4d::model
