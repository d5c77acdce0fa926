#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::measure {

/// Finds the components of the slices in all slots (SlabReeb), and which of one slot continue in
/// the next.
///
/// Two cells with a common edge are of one component in all slots of that edge, which is a link
/// between them. A cell that a link connects to another for as long as it lasts is a part of that
/// one's item; only the others are items of their own, and few. Slots are halved again and again;
/// items that a link connects throughout a range of slots are one item there and in all its parts,
/// so that few of them are left to be divided (offline dynamic connectivity). Items that nothing
/// connects or divides within a range are a segment of it.
class SlotParts {
 public:
  struct Segment {
    std::uint32_t firstSlot;
    std::uint32_t lastSlot;
    std::uint32_t cell;
    bool isNode;  ///< at an instant, with vertices
  };
  struct Item {
    std::uint32_t firstSlot;
    std::uint32_t lastSlot;
    std::uint32_t cell;
  };
  struct Link {
    std::uint32_t a = model::kNoIndex;
    std::uint32_t b = model::kNoIndex;
    std::uint32_t firstSlot = 0;
    std::uint32_t lastSlot = 0;
  };
  /// A cell of an item that does not last as long.
  struct Part {
    std::uint32_t item = model::kNoIndex;
    std::uint32_t firstSlot = 0;
    std::uint32_t lastSlot = 0;
    std::uint32_t cell = 0;
  };
  /// A vertex of an item, of which the segment is wanted.
  struct Mark {
    std::uint32_t vertex;
    std::uint32_t item;
  };
  struct Range {
    std::vector<Item> items = {};
    std::vector<Link> links = {};
    std::vector<Part> parts = {};
    std::vector<Mark> marks = {};
  };

  explicit SlotParts(std::span<const std::uint32_t> slotOfVertex)
      : segmentOfVertex(slotOfVertex.size(), model::kNoIndex), slotOfVertex_(slotOfVertex) {}

  /// Sets the segments of each item in the first and in the last slot, if it exists there.
  void find(std::uint32_t first, std::uint32_t last, Range whole,
            std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& lasts);

  std::vector<Segment> segments;
  /// Segments, of which the second continues the first.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joins;
  std::vector<std::uint32_t> segmentOfVertex;

 private:
  void divide(std::uint32_t first, std::uint32_t last, Range range,
              std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& lasts);
  void settle(Range& range, std::span<const std::uint32_t> segmentOf);
  void halve(std::uint32_t first, std::uint32_t last, Range range, const std::vector<char>& divided,
             std::vector<std::uint32_t>& firstOf, std::vector<std::uint32_t>& lastOf);

  std::span<const std::uint32_t> slotOfVertex_;
};

}  // namespace t4d::measure
