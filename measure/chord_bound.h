#pragma once

#include <optional>

#include "model/chords.h"
#include "t4d/mesh.h"

namespace t4d::measure {

/// How far a swept mesh can be from the rigid motion that it was made of (model::Chords). The
/// motion from one pose to the next is taken to be a uniform screw of at most half a turn (Chasles'
/// theorem).
struct ChordBound : model::Chords {
  double bound = 0;         ///< the largest of any step, and `rounding`, in length units
  bool isStated = false;    ///< MotionBetweenLayers::bound; the rest is that of the screws
  double angleRadians = 0;  ///< of the step that has it, as the radius and the edge
  /// The distance by which rounding coordinates to float32 moves points; 0 for float64.
  double rounding = 0;
};

/// The known facts about the motion from one layer to the next.
struct MotionBetweenLayers {
  /// It is the screw from pose to pose, or has a stated bound; otherwise nothing is known.
  bool isKnown = true;
  /// How far the mesh can be from the motion, in length units, where that is no screw: the motion
  /// of several joints.
  std::optional<double> bound = {};
};

/// The bound for the slabs that have a part of `span`. Nothing if the mesh has layers without a
/// pose (of deformations, of voxels), or if nothing else is known of the motion between them.
Result<std::optional<ChordBound>> chordBound(const model::Source& source,
                                             const model::TimeSpan& span,
                                             const MotionBetweenLayers& motion = {},
                                             const model::Progress& progress = {});

}  // namespace t4d::measure
