#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/collide.h"

namespace t4d::measure {

/// A connected part of a body's surface during a time in which it does not meet another body, so
/// that all of it lies inside that one, or all outside.
struct SurfacePart {
  double begin = 0;  ///< when it exists
  double end = 0;
  std::uint32_t cell = 0;  ///< one of its cells that exist at `begin`
  /// A point of it at a time when many parts exist.
  model::Point4 point = model::Point4::Zero();
};

/// The parts of the surface of one of two bodies that lie inside the other body, followed from slab
/// to slab.
class InsideParts {
 public:
  /// Call for each gap between contacts, in time order: an open span in one slab of either body.
  /// `joinedToLast` says that the gap continues the one before without a contact in between, and in
  /// the same or the next slab. Returns the parts that lie inside the other.
  Result<std::vector<SurfacePart>> find(const model::Slab& slab, std::uint64_t slabNumber,
                                        const model::TimeSpan& gap, const model::Slab& other,
                                        const model::Bounds4& boundsOfOther, bool joinedToLast);

 private:
  struct Parts {
    std::vector<std::uint32_t> ofCell;  // model::kNoIndex for cells that do not exist in the gap
    std::vector<SurfacePart> all;
  };
  static Parts partsOf(const model::Slab& slab, const model::TimeSpan& gap);

  // The parts in the last gap.
  Parts parts_;
  std::vector<std::uint8_t> inside_;  // of each part
  std::uint64_t slabNumber_ = ~std::uint64_t{0};
  std::shared_ptr<const model::Connectivity> connectivity_;
};

/// A point of a cell at a time when it exists.
model::Point3 pointAt(const model::Slab& slab, std::uint32_t cell, double time);

}  // namespace t4d::measure
