#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "model/surface_edges.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using model::EdgeSides;
using model::Triangle;
using model::TriangleMesh;

bool turnsAlike(const Triangle& a, const Triangle& b) {
  const auto at = std::ranges::find(b, a[0]) - b.begin();
  return b[(at + 1) % 3] == a[1];
}

/// Triangles with the same corners.
struct Equal {
  std::uint32_t first = 0;  ///< the first of them
  int count = 0;
  int net = 0;  ///< those that turn as `place` does, without those that turn the other way
};

/// The multiplicity with which each set of equal triangles counts. Sets form patches, which end
/// where more than two sets meet, and where sets of one triangle meet those of several. Where every
/// edge is traversed equally often in both directions, the net number is the same all over a patch.
class Multiplicities {
 public:
  Multiplicities(const TriangleMesh& mesh, std::vector<Equal> sets)
      : sets_(std::move(sets)), places_{mesh.vertices, {}, {}} {
    for (const Equal& set : sets_) places_.triangles.push_back(mesh.triangles[set.first]);
    edges_ = model::edgesOf(places_.triangles);
    makePatches();
    balance_.resize(edges_.edges.size());
    std::vector<double> size(sets_.size());
    std::vector<double> net(sets_.size());
    for (std::uint32_t i = 0; i < sets_.size(); ++i) {
      size[patches_.root(i)] += 1;
      net[patches_.root(i)] += sets_[i].net;
    }
    number_.resize(sets_.size(), 1);
    for (std::uint32_t i = 0; i < sets_.size(); ++i) {
      if (isPatchOfSeveral(i)) number_[i] = static_cast<int>(std::lround(net[i] / size[i]));
    }
    findRims();
    balancePatches();
    keepTwoSided();
  }

  /// The triangle that stands for a set, and how often it counts; a negative number turns it.
  const Triangle& place(std::uint32_t set) const { return places_.triangles[set]; }
  int number(std::uint32_t set) { return cancelled_[set] ? 0 : number_[patches_.root(set)]; }

 private:
  /// The part of the rim of a patch at one edge: how often the patch traverses it forward.
  struct RimEdge {
    std::uint32_t edge = 0;
    int forward = 0;
  };

  bool isPatchOfSeveral(std::uint32_t set) {
    return patches_.root(set) == set && sets_[set].count > 1;
  }

  void makePatches() {
    std::vector<std::uint32_t> mates(edges_.sides.size(), model::kNoIndex);
    for (const EdgeSides& edge : edges_.edges) {
      if (edge.end - edge.begin != 2) continue;
      const std::uint32_t a = edges_.sides[edge.begin];
      const std::uint32_t b = edges_.sides[edge.begin + 1];
      if ((sets_[a / 3].count > 1) != (sets_[b / 3].count > 1)) continue;
      mates[a] = b;
      mates[b] = a;
    }
    patches_.reset(sets_.size());
    for (std::uint32_t side = 0; side < mates.size(); ++side) {
      if (mates[side] != model::kNoIndex) patches_.unite(side / 3, mates[side] / 3);
    }
    const std::vector<Triangle> before = places_.triangles;
    if (!turnToAgree(places_, mates)) return;  // it has one side: each set counts as it comes
    for (std::size_t i = 0; i < sets_.size(); ++i) {
      if (!turnsAlike(before[i], places_.triangles[i])) sets_[i].net = -sets_[i].net;
    }
    edges_ = model::edgesOf(places_.triangles);
  }

  void findRims() {
    rims_.resize(sets_.size());
    std::vector<std::pair<std::uint32_t, int>> parts;
    for (std::uint32_t e = 0; e < edges_.edges.size(); ++e) {
      const EdgeSides& edge = edges_.edges[e];
      if (edge.end - edge.begin < 2) continue;  // a hole, which says nothing
      parts.clear();
      for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
        const std::uint32_t side = edges_.sides[i];
        parts.emplace_back(patches_.root(side / 3), isForward(places_, side) ? 1 : -1);
      }
      std::ranges::sort(parts);
      for (std::size_t i = 0; i < parts.size();) {
        const std::uint32_t patch = parts[i].first;
        int forward = 0;
        for (; i < parts.size() && parts[i].first == patch; ++i) forward += parts[i].second;
        balance_[e] += forward * number_[patch];
        if (forward != 0 && sets_[patch].count > 1) rims_[patch].push_back({e, forward});
      }
    }
  }

  /// What is left at the edges of a rim, in total, if the patch counts `number` times.
  std::int64_t imbalanceOf(std::uint32_t patch, int number) const {
    std::int64_t sum = 0;
    for (const auto& [edge, forward] : rims_[patch]) {
      sum += std::abs(balance_[edge] + (number - number_[patch]) * forward);
    }
    return sum;
  }

  /// The number that balances most of the rim: a median.
  int bestNumber(std::uint32_t patch) const {
    std::vector<int> wanted;
    for (const auto& [edge, forward] : rims_[patch]) {
      wanted.push_back(number_[patch] - balance_[edge] / forward);
    }
    const auto middle = wanted.begin() + std::ssize(wanted) / 2;
    std::ranges::nth_element(wanted, middle);
    return *middle;
  }

  void balancePatches() {
    // Each change balances the surface better, so this ends; the bound is for the time that it
    // takes.
    constexpr int kMostRounds = 100;
    bool changed = true;
    for (int round = 0; changed && round < kMostRounds; ++round) {
      changed = false;
      for (std::uint32_t patch = 0; patch < sets_.size(); ++patch) {
        if (rims_[patch].empty()) continue;
        const int best = bestNumber(patch);
        if (imbalanceOf(patch, best) >= imbalanceOf(patch, number_[patch])) continue;
        for (const auto& [edge, forward] : rims_[patch]) {
          balance_[edge] += (best - number_[patch]) * forward;
        }
        number_[patch] = best;
        changed = true;
      }
    }
    for (std::uint32_t patch = 0; patch < sets_.size(); ++patch) {
      if (!isPatchOfSeveral(patch)) continue;
      const auto& rim = rims_[patch];
      const auto balanced =
          std::ranges::count_if(rim, [&](const RimEdge& at) { return balance_[at.edge] == 0; });
      // A patch that is closed counts once, however often it is given. So does one that fits its
      // surroundings with no number.
      if (2 * balanced >= std::ssize(rim) && (!rim.empty() || number_[patch] == 0)) continue;
      number_[patch] = number_[patch] < 0 ? -1 : 1;
    }
  }

  /// Sheets with two sides cancel. A connected part with two sides everywhere that encloses
  /// something is the surface of a solid, given with both sides.
  void keepTwoSided() {
    cancelled_.resize(sets_.size());
    model::UnionFind parts(sets_.size());
    for (const EdgeSides& edge : edges_.edges) {
      for (std::uint32_t i = edge.begin + 1; i < edge.end; ++i) {
        parts.unite(edges_.sides[edge.begin] / 3, edges_.sides[i] / 3);
      }
    }
    std::vector<bool> counts(sets_.size());
    for (std::uint32_t i = 0; i < sets_.size(); ++i) {
      if (number_[patches_.root(i)] != 0) counts[parts.root(i)] = true;
    }
    std::vector<std::vector<std::uint32_t>> edgesAt(sets_.size());
    std::vector<std::uint32_t> left(edges_.edges.size());
    for (std::uint32_t e = 0; e < edges_.edges.size(); ++e) {
      const EdgeSides& edge = edges_.edges[e];
      left[e] = edge.end - edge.begin;
      for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
        edgesAt[edges_.sides[i] / 3].push_back(e);
      }
    }
    const auto isFree = [&](std::uint32_t set) {
      return std::ranges::any_of(edgesAt[set], [&](std::uint32_t e) { return left[e] == 1; });
    };
    std::vector<std::uint32_t> open;
    for (std::uint32_t i = 0; i < sets_.size(); ++i) {
      if (number_[patches_.root(i)] == 0 && isFree(i)) open.push_back(i);
    }
    while (!open.empty()) {
      const std::uint32_t set = open.back();
      open.pop_back();
      if (cancelled_[set]) continue;
      cancelled_[set] = true;
      for (const std::uint32_t e : edgesAt[set]) {
        if (--left[e] != 1) continue;
        const EdgeSides& edge = edges_.edges[e];
        for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
          const std::uint32_t next = edges_.sides[i] / 3;
          if (!cancelled_[next] && number_[patches_.root(next)] == 0) open.push_back(next);
        }
      }
    }
    for (std::uint32_t i = 0; i < sets_.size(); ++i) {
      if (number_[patches_.root(i)] == 0 && counts[parts.root(i)]) cancelled_[i] = true;
    }
    for (std::uint32_t i = 0; i < sets_.size(); ++i) {
      if (patches_.root(i) == i && number_[i] == 0) number_[i] = 1;
    }
  }

  std::vector<Equal> sets_;
  TriangleMesh places_;  // a triangle for each set; those of a patch agree
  model::SurfaceEdges edges_;
  model::UnionFind patches_;
  std::vector<int> number_;                 // of each patch, at its root
  std::vector<std::vector<RimEdge>> rims_;  // of patches of several, at their root
  std::vector<int> balance_;                // forward minus backward, of each edge
  std::vector<bool> cancelled_;             // of each set
};

/// The sets of equal triangles, in the order of their first ones; and the set of each triangle.
std::pair<std::vector<Equal>, std::vector<std::uint32_t>> setsOf(const TriangleMesh& mesh) {
  std::vector<Triangle> keys = mesh.triangles;
  for (Triangle& key : keys) std::ranges::sort(key);
  std::vector<std::uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
  });
  std::vector<std::uint32_t> firstOf(keys.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool again = i > 0 && keys[order[i]] == keys[order[i - 1]];
    firstOf[order[i]] = again ? firstOf[order[i - 1]] : order[i];
  }
  std::vector<Equal> sets;
  std::vector<std::uint32_t> setOf(keys.size());
  for (std::uint32_t i = 0; i < keys.size(); ++i) {
    if (firstOf[i] == i) {
      setOf[i] = static_cast<std::uint32_t>(sets.size());
      sets.push_back({.first = i});
    }
    setOf[i] = setOf[firstOf[i]];
    Equal& set = sets[setOf[i]];
    ++set.count;
    set.net += turnsAlike(mesh.triangles[set.first], mesh.triangles[i]) ? 1 : -1;
  }
  return {std::move(sets), std::move(setOf)};
}

}  // namespace

Result<void> dropDuplicates(TriangleMesh& mesh, Changes& changes) {
  const std::size_t collapsed = std::erase_if(mesh.triangles, hasTwice);
  note(changes, SurfaceFault::Duplicate, collapsed,
       fmt::format("dropped {} with a corner twice", numberOf(collapsed, "triangle", "triangles")));
  if (mesh.triangles.empty()) return invalid("no triangle has three different corners");
  const auto [sets, setOf] = setsOf(mesh);
  if (sets.size() == mesh.triangles.size()) return {};
  Multiplicities multiplicities(mesh, sets);
  std::vector<Triangle> kept;
  std::size_t duplicates = 0;
  std::size_t cancelled = 0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const Equal& set = sets[setOf[i]];
    if (set.first != i) continue;
    Triangle triangle = mesh.triangles[i];
    if (set.count == 1) {
      kept.push_back(triangle);
      continue;
    }
    const int number = multiplicities.number(setOf[i]);
    if (turnsAlike(triangle, multiplicities.place(setOf[i])) != (number > 0)) reverse(triangle);
    const int copies = std::min(std::abs(number), set.count);
    kept.insert(kept.end(), copies, triangle);
    (number == 0 ? cancelled : duplicates) += set.count - copies;
  }
  if (kept.empty()) {
    return fail(ErrorCode::Unsupported,
                "the surface encloses nothing: each triangle is given twice, facing both ways");
  }
  mesh.triangles = std::move(kept);
  note(changes, SurfaceFault::Duplicate, duplicates,
       fmt::format("dropped {} with the corners of another one",
                   numberOf(duplicates, "triangle", "triangles")));
  note(changes, SurfaceFault::Duplicate, cancelled,
       fmt::format("dropped {} that {} by another one with the same corners, facing the other way",
                   numberOf(cancelled, "triangle", "triangles"),
                   cancelled == 1 ? "is cancelled" : "are cancelled"));
  return {};
}

}  // namespace t4d::edit
