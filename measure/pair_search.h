#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "measure/cell_tree.h"
#include "measure/contact_stretches.h"
#include "measure/inside_parts.h"
#include "t4d/collide.h"

namespace t4d::measure {

/// The time that a slab of one body and one of another share.
struct SlabWindow {
  model::TimeSpan span;
  std::size_t slabA = 0;
  std::size_t slabB = 0;
};

/// A slab of a body, with a tree of its cells in a window of time.
class LoadedSlab {
 public:
  explicit LoadedSlab(const model::Source& source) : source_(&source) {}

  /// Reads the slab and fits the tree, unless that is done.
  Result<void> load(std::size_t index, const model::TimeSpan& window);

  const model::Source& source() const { return *source_; }
  std::size_t number() const { return number_; }
  const model::Slab& slab() const { return *slab_; }
  const CellTree& tree() const { return tree_; }

 private:
  const model::Source* source_;
  std::size_t number_ = ~std::size_t{0};
  model::TimeSpan window_{std::numeric_limits<double>::quiet_NaN(), 0};
  std::shared_ptr<const model::Slab> slab_;
  CellTree tree_;
};

/// The search for contacts of two bodies, and for their smallest distance (collide.h), window by
/// window.
class PairSearch {
 public:
  /// Both slabs must outlive this object.
  PairSearch(const LoadedSlab& a, const LoadedSlab& b, const CollideOptions& options);

  /// The windows in time order. One that is an instant only counts if no other includes it, as
  /// between two bodies of which one starts when the other ends.
  const std::vector<SlabWindow>& windows() const { return windows_; }

  /// Call it for each window in order, with its slabs loaded.
  Result<void> findContacts(std::size_t window);
  /// Call it once, after the last of these.
  void finishContacts();

  /// Whether the distance is to be found, too.
  bool findsClearance() const;
  /// The window in which the boxes of the solids are least apart.
  std::size_t nearestByBoxes() const;
  /// Whether findClearance looks at the slabs of this window.
  bool mayBeNearest(std::size_t window) const;
  /// Call it for each window in order, with its slabs loaded if they may be nearest.
  void findClearance(std::size_t window);

  /// Call it last, and once.
  Result<Collision> finish();

 private:
  void roundOnce();
  Result<void> findInside(const model::TimeSpan& span, bool continued);
  void addInside(const SurfacePart& part, const LoadedSlab& side, bool isA,
                 const model::TimeSpan& span);
  void join();
  bool isInContact(const SlabWindow& window) const;
  void finishBefore(double time);

  CollideOptions options_;
  const LoadedSlab& a_;
  const LoadedSlab& b_;
  std::vector<SlabWindow> windows_;
  std::vector<double> apart_;  // of each window, how far the boxes about both slabs are apart
  InsideParts insideA_;
  InsideParts insideB_;
  ContactStretches open_;  // of the window, and what reaches it
  std::vector<ContactInterval> intervals_;
  Clearance nearest_;
  Clearance last_;
  std::vector<ClearanceOver> overTime_;
  double lastWindowEnd_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace t4d::measure
