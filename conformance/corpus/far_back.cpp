#include "conformance/corpus/far_back.h"

#include <fmt/format.h>

#include "conformance/corpus/shapes.h"

namespace t4d::conformance {
namespace {

using model::Connectivity;
using model::Point4;
using model::Slab;

/// The simplex number `k` of the first body, from time k to k + 1. Where it has a layer above, that
/// is its apex; the layer below is the apex of the simplex before.
Slab link(std::uint32_t k, bool lower, bool upper) {
  const double place = k;
  Slab slab = simplex(1, {place, 0, 0, place})[0];
  auto connectivity = std::make_shared<Connectivity>(*slab.connectivity);
  if (lower) {
    slab.vertices.insert(slab.vertices.begin(), Point4(place - 1, 0, 0, place));
    for (model::Cell& cell : connectivity->cells) {
      for (std::uint32_t& vertex : cell) ++vertex;
    }
  }
  connectivity->vertexCount = static_cast<std::uint32_t>(slab.vertices.size());
  connectivity->lowerCount = lower ? 1 : 0;
  connectivity->upperCount = upper ? 1 : 0;
  slab.connectivity = connectivity;
  return slab;
}

}  // namespace

FarFile partFarBack(FarPart part, std::uint32_t bodies, std::uint32_t back) {
  std::vector<BodySlabs> all;
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < bodies; ++i) {
    all.push_back({fmt::format("body {}", i), simplex(1, {-2.0 * i, 0, 0, 0})});
    names.push_back(all.back().name);
  }
  std::vector<Slab>& slabs = all[0].slabs;
  slabs.clear();
  const bool posed = part == FarPart::Pose || part == FarPart::LayerOfPose;
  Image image(
      headJson(posed ? std::vector<std::string>{"pose"} : std::vector<std::string>{}, names));
  if (part != FarPart::Connectivity) {
    for (const bool lower : {false, true}) {
      image.addConnectivity(lower ? "inner" : "first", *link(0, lower, true).connectivity);
    }
  }
  const auto layer = [&](std::uint32_t k) {
    image.addLayer(fmt::format("LAYR {}", k), k + 1.0, link(k, false, true).upperLayer());
  };
  const auto pose = [&](std::uint32_t k, const std::string& of, double by) {
    image.addPose(fmt::format("POSE {}", k), k + 1.0, movedBy({by, 0, 0}), of);
  };
  const auto add = [&](std::uint32_t k, const std::string& connectivity, const std::string& lower,
                       const std::string& upper) {
    slabs.push_back(link(k, !lower.empty(), !upper.empty()));
    image.addSlab(fmt::format("SLAB {}", k), 0, slabs.back(), connectivity, lower, upper);
  };
  const std::string kind = part == FarPart::Pose ? "POSE" : "LAYR";
  const auto addLinked = [&](std::uint32_t k, const std::string& upper) {
    add(k, k == 0 ? "first" : "inner", k == 0 ? "" : fmt::format("{} {}", kind, k - 1), upper);
  };
  if (part == FarPart::Layer || part == FarPart::Pose) {
    if (part == FarPart::Pose) layer(0);
    for (std::uint32_t k = 0; k < back; ++k) {
      if (part == FarPart::Layer) {
        layer(k);
      } else {
        pose(k, "LAYR 0", k);
      }
    }
  }
  for (std::uint32_t k = 0; k < back; ++k) {
    if (part == FarPart::Connectivity) {
      image.addConnectivity(fmt::format("CONN {}", k), *link(k, false, false).connectivity);
      add(k, fmt::format("CONN {}", k), "", "");
    } else {
      if (part == FarPart::LayerOfPose) layer(k);
      addLinked(k, fmt::format("{} {}", kind, k));
    }
  }
  if (part == FarPart::Connectivity) add(back, "CONN 0", "", "");
  if (part == FarPart::LayerOfPose) {
    pose(back, "LAYR 0", back);
    addLinked(back, fmt::format("POSE {}", back));
  }
  if (bodies > 1) image.addConnectivity("simplex", *all[1].slabs[0].connectivity);
  for (std::uint32_t i = 1; i < bodies; ++i) {
    image.addSlab(fmt::format("other {}", i), i, all[i].slabs[0], "simplex", "", "");
  }
  image.addEnd();
  return {image, all};
}

}  // namespace t4d::conformance
