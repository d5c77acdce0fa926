#pragma once

#include <span>
#include <vector>

#include "t4d/collide.h"

namespace t4d::measure {

/// A time during which cells of two bodies meet.
struct ContactStretch {
  double begin = 0;
  double end = 0;
  Contact first;  ///< at `begin`
  Contact last;   ///< at `end`; without a point
  bool overlaps = false;
  /// A time in the stretch during which two cells cross; an instant if there is none.
  model::TimeSpan crossing{0, 0};
  /// Whether `begin` and `end` are final: from earlier slabs, or rounded once.
  bool beginKnown = false;
  bool endKnown = false;
};

/// A set of times, as stretches that are apart. It does not depend on the order in which they are
/// added.
class ContactStretches {
 public:
  /// Unites it with those that it touches.
  void add(const ContactStretch& stretch);
  void add(const ContactStretches& others) {
    for (const ContactStretch& stretch : others.all_) add(stretch);
  }
  /// Whether a time span lies in a stretch that overlaps: what is in contact then adds nothing.
  bool covers(double begin, double end) const;
  /// Whether the span lies in any stretch: then only a crossing adds something.
  bool includes(double begin, double end) const;

  std::span<const ContactStretch> all() const { return all_; }
  std::span<ContactStretch> all() { return all_; }
  bool empty() const { return all_.empty(); }

 private:
  std::vector<ContactStretch> all_;
};

}  // namespace t4d::measure
