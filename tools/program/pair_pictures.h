#pragma once

#include <span>
#include <string>
#include <string_view>

#include "t4d/verbs/compare.h"

namespace t4d::tools {

using verbs::SolidPair;

/// What is said of pairs that are shown.
struct PairCaptions {
  std::string a;
  std::string b;
  std::string lengthUnit;  ///< "" if unknown
  std::string timeUnit;
  bool zUp = false;
  double farthest = 0;  ///< the largest Hausdorff distance, of these and other times
};

/// Pictures of the solids of each pair, plain and coloured by the distance of one from the other,
/// for a page with `kPairStyle`. All share one scale of lengths and of colours.
std::string pairPictures(const PairCaptions& captions, std::span<const SolidPair> pairs);

extern const std::string_view kPairStyle;

}  // namespace t4d::tools
