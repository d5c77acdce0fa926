#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/union_find.h"

namespace t4d::edit {

/// The numbers of connected parts of a vertex's link before and after the time of the vertex. If
/// the link is a sphere, slices change their topology at the vertex unless both are 1 (Banchoff
/// 1967). If one is 0, a component begins or ends; if one is above 1, components merge or part.
struct LinkSides {
  std::uint32_t before = 0;
  std::uint32_t after = 0;

  bool isRegular() const { return before == 1 && after == 1; }
  friend bool operator==(const LinkSides&, const LinkSides&) = default;
};

/// Counts LinkSides for one link after another; reuses its buffers.
class LinkSideCounter {
 public:
  explicit LinkSideCounter(std::size_t vertexCount) : slots_(vertexCount, {0, 0}) {}

  void clear() {
    ++link_;
    isBefore_.clear();
    triangles_.clear();
  }

  /// `isBefore` tells whether a vertex is before the time.
  template <class IsBefore>
  void addTriangle(const std::array<std::uint32_t, 3>& triangle, IsBefore isBefore) {
    auto& numbers = triangles_.emplace_back();
    for (int i = 0; i < 3; ++i) numbers[i] = numberOf(triangle[i], isBefore);
  }

  LinkSides sides() {
    LinkSides sides;
    for (const bool before : isBefore_) ++(before ? sides.before : sides.after);
    uniteAlongEdges([&](auto from, auto to) { return isBefore_[from] == isBefore_[to]; },
                    [&](auto from) { --(isBefore_[from] ? sides.before : sides.after); });
    return sides;
  }

  /// Whether the link, which is closed, is a sphere: connected, with V - E + F = 2.
  bool isSphere() {
    std::size_t parts = isBefore_.size();
    uniteAlongEdges([](auto, auto) { return true; }, [&](auto) { --parts; });
    return parts == 1 && isBefore_.size() == 2 + triangles_.size() / 2;
  }

 private:
  struct Slot {
    std::uint64_t link;    // the link of the vertex
    std::uint32_t number;  // its number in this link
  };

  template <class IsBefore>
  std::uint32_t numberOf(std::uint32_t vertex, IsBefore isBefore) {
    Slot& slot = slots_[vertex];
    if (slot.link != link_) {
      slot = {link_, static_cast<std::uint32_t>(isBefore_.size())};
      isBefore_.push_back(isBefore(vertex));
    }
    return slot.number;
  }

  template <class Wanted, class OnUnited>
  void uniteAlongEdges(Wanted wanted, OnUnited onUnited) {
    parts_.reset(isBefore_.size());
    for (const auto& triangle : triangles_) {
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t from = triangle[i];
        const std::uint32_t to = triangle[(i + 1) % 3];
        if (wanted(from, to) && parts_.unite(from, to)) onUnited(from);
      }
    }
  }

  std::vector<Slot> slots_;
  std::uint64_t link_ = 0;
  std::vector<char> isBefore_;  // one for each vertex of the link
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  model::UnionFind parts_;
};

}  // namespace t4d::edit
