#pragma once

#include <cstdint>
#include <vector>

#include "conformance/corpus/image.h"

/// Files whose slabs name parts many parts back (rules K6 and S12).
namespace t4d::conformance {

enum class FarPart : std::uint8_t {
  Connectivity,  ///< the last slab names an early CONN
  Layer,         ///< all LAYRs come before the first slab, which names the first of them
  Pose,          ///< likewise, with POSEs of one LAYR
  LayerOfPose,   ///< the last POSE moves the first LAYR
};

struct FarFile {
  Image image;
  std::vector<BodySlabs> bodies;
};

/// A file of `bodies` bodies, the first of which names a part that is `back` parts of its kind
/// back, 1 being the last one. It consists of simplices of height 1, one above the other; with
/// layers, each is the apex of the simplex below. The other bodies are a simplex each.
FarFile partFarBack(FarPart part, std::uint32_t bodies, std::uint32_t back);

}  // namespace t4d::conformance
