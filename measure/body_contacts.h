#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "t4d/check.h"
#include "t4d/mesh.h"

/// Contacts between bodies whose surfaces have vertices in common, such as those of one mesh of
/// labels: which of them touch, when, and over what area.
///
/// Two bodies touch in a triangle of the slice of one if each of its corners is a point of the
/// slice of the other, too: a vertex of both meshes, or on an edge between two such. They touch
/// from layer to layer as long as they do so at both of them, and at the times of cells whose four
/// vertices both have. Bodies that touch in other ways have no contact here; collide finds them.
namespace t4d::measure {

struct ContactSample {
  double time = 0;
  /// The mean of what the slices of the two bodies have of it.
  double area = 0;
};

/// A time without a break in which two bodies touch.
struct BodyContact {
  std::size_t body = 0;   ///< the first of the two, by its number
  std::size_t other = 0;  ///< the second
  double begin = 0;
  double end = 0;
  /// The largest area of its samples and at layers; if there are none, the area at a time in
  /// between.
  double largestArea = 0;
  std::vector<ContactSample> samples = {};  ///< in the order of time
};

/// The times between which slabs of several bodies last, without those of no duration: contacts are
/// found in each alone.
std::uint64_t contactSpanCount(std::span<const model::Body> bodies);

/// The contacts of bodies, in the order of their begin, at the times of `options` (only `times` and
/// `layers` count); in some of the spans alone, if given. Each thread has a slab of each body in
/// memory. Fails if reading a slab does.
Result<std::vector<BodyContact>> contactsOf(std::span<const model::Body> bodies,
                                            const TrackOptions& options,
                                            std::optional<model::PartRange> spans = {},
                                            const model::Progress& progress = {});

/// The contacts of the whole from those of all its spans, in any order.
std::vector<BodyContact> joinedContacts(std::vector<BodyContact> contacts);

}  // namespace t4d::measure
