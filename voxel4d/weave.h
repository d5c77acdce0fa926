#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "model/part.h"
#include "model/slab.h"
#include "voxel4d/frame.h"
#include "voxel4d/lost_part.h"

namespace t4d::voxel4d {

/// How the mesh is closed before the first frame and after the last, where everything is outside.
enum class CapStyle : std::uint8_t {
  /// With cells exactly at the first and the last time: the mesh lasts as long as the frames.
  Flat,
  /// As published: the surface closes half a step before the first frame and after the last.
  HalfStep,
  /// Like Flat, with cells that grow inwards (graded_cap.h): far fewer, for the same solid.
  Graded,
};

/// When a point that changes sides between two frames does so, where nothing tells how far from the
/// surface it is: in masks, labels, and samples of two values.
enum class Between : std::uint8_t {
  /// By its distances from the faces between voxels inside and outside of both frames, so that the
  /// surface moves evenly from frame to frame (mask_distance.h).
  Distance,
  /// In the middle between the frames, as published: everything jumps there.
  Midpoint,
};

struct WeaveOptions {
  CapStyle caps = CapStyle::Flat;
  Between between = Between::Distance;
  /// Maps positions of the lattice to space. It may turn, skew and mirror; the mesh stays outward.
  std::optional<model::Affine3x4> toSpace = {};
  /// From how many bytes of values on a frame keeps them in a temporary file.
  std::size_t largeFrame = kLargeFrame;
  /// A share of the steps from frame to frame: only their frames are read. The first part has the
  /// cap of the first frame, the last that of the last; where two parts meet, both have the layer
  /// of the frame, with the same bytes (formats::joinT4d).
  model::Part part = {};
};

struct WeaveReport {
  std::uint64_t vertices = 0;  ///< without those of the layer that the part before has, too
  std::uint64_t tetrahedra = 0;
  std::uint64_t frames = 0;
  std::uint64_t masks = 0;  ///< of the frames, those that WeaveOptions::between concerns
  std::array<std::uint64_t, 2> capTetrahedra = {0, 0};  ///< start, end
  LostParts partsLost = {};
};

/// Weaves frames into a 4D mesh by 4D marching cubes (paper, section 3.2; see pattern_table.h) and
/// puts it into `sink`: a cap, a slab between every two frames, a cap. Two frames are in memory at
/// a time, of large ones only the signs and the values of the last one read. Only blocks that the
/// surface meets are processed.
///
/// The vertices of a layer are the crossings of the frame's lattice edges, in an order that depends
/// on the frame alone; the interior vertices of a slab are those of edges in time. A crossing lies
/// where the field, linear along the edge, is zero, or, if a frame has no values, at the midpoint
/// in space and as WeaveOptions::between says in time; of float32 values it is rounded to a
/// millionth (2^-20) of the edge, about what they tell. Blocks are distributed over threads
/// (oneTBB); the result is the same for any number of them.
///
/// Fails for fewer than two frames, a frame that checkFrame or checkPlace refuses, times that do
/// not increase by model::kSmallestExtent or are beyond model::kLargestCoordinate, more than 2^32 -
/// 1 vertices or cells in a slab, no frame with anything inside (unless it is a part), more parts
/// than steps, and a temporary file that cannot
/// be written; and if the source or the sink does.
Result<WeaveReport> weave(FrameSource& frames, const WeaveOptions& options, model::Sink& sink,
                          const model::Progress& progress = {});

}  // namespace t4d::voxel4d
