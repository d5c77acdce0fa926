#pragma once

/// The voxel method: frames become slabs by 4D marching cubes; and solids become frames.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/frames.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::voxel4d {

/// A part of a solid that ends between two frames, although one of like size begins near it there:
/// most likely it moves by its own width or more, and between the frames it shrinks or vanishes.
struct LostPart {
  std::size_t frame = 0;                        ///< the last that has it
  double time = 0;                              ///< of that frame
  model::Point3 point = model::Point3::Zero();  ///< its centroid there
  std::uint64_t voxels = 0;                     ///< lattice points inside of it there
};

struct LostParts {
  static constexpr std::size_t kMostListed = 1000;

  std::uint64_t count = 0;
  std::vector<LostPart> listed = {};  ///< the first, in the order of frames, in a frame the largest

  /// Adds the lost parts of another body.
  void add(const LostParts& other) {
    count += other.count;
    const std::size_t room = kMostListed - listed.size();
    listed.insert(
        listed.end(), other.listed.begin(),
        other.listed.begin() + static_cast<std::ptrdiff_t>(std::min(room, other.listed.size())));
  }
};

/// The way in which the mesh is closed before the first frame and after the last, where everything
/// is outside.
enum class CapStyle : std::uint8_t {
  /// The caps have cells exactly at the first and the last time: the mesh lasts as long as the
  /// frames.
  Flat,
  /// The surface closes half a step before the first frame and after the last, as published.
  HalfStep,
  /// Like Flat, with cells that grow inwards (graded_cap.h): far fewer, for the same solid.
  Graded,
};

/// When a point that changes sides between two frames does so, where nothing tells how far from the
/// surface it is: in masks, labels, and samples of two values.
enum class Between : std::uint8_t {
  /// The change depends on the distances from the faces between voxels inside and outside of both
  /// frames, so that the surface moves evenly from frame to frame (mask_distance.h).
  Distance,
  /// The change is in the middle between the frames, as published: everything jumps there.
  Midpoint,
};

struct WeaveOptions {
  CapStyle caps = CapStyle::Flat;
  Between between = Between::Distance;
  /// Maps positions of the lattice to space. It may turn, skew and mirror; the mesh stays outward.
  std::optional<model::Affine3x4> toSpace = {};
  /// Frames with at least this many bytes of values keep them in a temporary file.
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

/// A solid as a function of time: closed and facing outward; empty if there is none.
using SolidAtTime = std::function<Result<model::TriangleMesh>(double time)>;

/// `mesh` in the poses of `motion`.
SolidAtTime movingSolid(model::TriangleMesh mesh, model::Motion motion);

struct VoxelizeOptions {
  /// The edge length of a voxel. Lattice points are its multiples, so the origin is one of them.
  double voxelSize = 1;
  /// Store only which points are strictly inside (see occupancy.h), instead of the distance from
  /// the surface in a band of three voxels on either side.
  bool mask = false;
  /// The share of the frames that is written, under the names that they have in the whole series.
  /// What is inside in the frame after them is looked at, too: for the parts that are lost.
  model::Part part = {};
  /// The places of errors about each frame of voxelFrames, such as its file; without them, its
  /// number.
  std::vector<Place> places = {};
};

/// The solid at each of `times`, computed when its frame is requested. Fails if checkVoxelizable or
/// `solid` does.
std::unique_ptr<FrameSource> voxelFrames(SolidAtTime solid, std::vector<double> times,
                                         const VoxelizeOptions& options);

struct VoxelSeries {
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;             ///< of all files
  std::uint64_t insidePoints = 0;      ///< of all frames
  std::uint64_t emptyFrames = 0;       ///< without inside points
  std::uint64_t mostActiveVoxels = 0;  ///< in any one frame
  struct File {
    std::string name = {};  ///< beside the others
    std::uint64_t bytes = 0;
  };
  std::vector<File> files = {};  ///< of the frames, in their order
  LostParts partsLost = {};
};

/// Writes the frames of voxelFrames into `folder` (created if missing) as frame_0000.vdb, ...:
/// level sets named "surface", or bool grids named "inside" whose true values are active. The
/// metadata `t4d_time` of each is its time.
///
/// The series appears completely or not at all: files are renamed after all have been written.
/// Before that `beforeRenaming`, if there is one, can remove what described a series of these
/// names. Fails if voxelFrames or it does, or if the folder has other .vdb files, which would be
/// taken for frames of this series.
Result<VoxelSeries> writeVoxelFrames(const SolidAtTime& solid, const std::vector<double>& times,
                                     const VoxelizeOptions& options,
                                     const std::filesystem::path& folder,
                                     const model::Progress& progress = {},
                                     const std::function<Result<void>()>& beforeRenaming = {});

}  // namespace t4d::voxel4d
