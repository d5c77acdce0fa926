#pragma once

#include <span>
#include <string>

#include "t4d/file.h"
#include "tools/t4d/compare.h"

namespace t4d::tools {

/// The captions of pairs that are shown.
struct PairCaptions {
  std::string a;
  std::string b;
  double farthest = 0;  ///< the largest Hausdorff distance, of these and other times
};

/// Pictures of the solids of each pair, plain and coloured by the distance of one from the other.
/// All share one scale of lengths and of colours.
std::string pairPictures(const PairCaptions& captions, const formats::Metadata& metadata,
                         std::span<const SolidPair> pairs);

}  // namespace t4d::tools
