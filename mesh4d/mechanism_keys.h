#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mesh4d/prism.h"
#include "mesh4d/steps.h"
#include "model/mechanism.h"
#include "t4d/error.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::mesh4d {

/// A solid that moves with a link.
struct LinkSolid {
  const model::TriangleMesh* mesh = nullptr;
  std::size_t link = 0;
  model::Pose place = {};  ///< of the mesh in the world, while the mechanism is at rest
};

struct LinkKeys {
  std::unique_ptr<model::VertexKeys> keys;  ///< all have poses
  /// No point of a slice is farther from the true solid at that time, nor the other way round, in
  /// length units.
  double chordBound = 0;
};

/// The layers of the solids of a mechanism: at all times at which a motion changes, and between
/// them the number that `rule` requires.
///
/// If `common`, all solids that move have their layers at the same times, so that the 4D meshes of
/// solids that rest relative to each other do so, too; otherwise each has its own. A solid that
/// rests has two layers. No step turns a solid by more than half a turn, whatever the rule.
///
/// The bound holds for the motion that is composed of those of the links: over a step of duration h
/// a vertex whose acceleration is at most a (model::accelerationBound) is at most h^2 a / 8 off
/// its chord. The difference of chord and path is affine in the place of the vertex, so the
/// corners of the box of a solid bound it for all vertices. To this comes what
/// model::edgeDeviation says of the layers.
///
/// `mechanism` must outlive the keys, and have a span; so must the meshes. Fails for a rule that
/// stepsOf refuses, and for more steps than `most` or, without that, than kMostMechanismSteps and
/// those that the times of the motions ask for.
Result<std::vector<LinkKeys>> mechanismKeys(const model::Mechanism& mechanism,
                                            std::span<const LinkSolid> solids, const StepRule& rule,
                                            PrismSplit split, bool common,
                                            std::optional<std::uint64_t> most = {});

/// The most steps of a solid between the times at which motions change. More take minutes: a wrong
/// unit, or a link far from its axis.
inline constexpr std::uint64_t kMostMechanismSteps = 100'000;

}  // namespace t4d::mesh4d
