#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/file_format.h"
#include "voxel4d/frame.h"
#include "voxel4d/region.h"

namespace t4d::voxel4d {

/// OpenVDB. Inline, as vdb_frames.cpp needs that library.
inline std::vector<platform::FileFormat> vdbFormats() {
  return {{"OpenVDB", {".vdb"}, {"level sets", "densities", "masks"}, true}};
}

/// The name of the grid metadata that holds its time: a number, written as double.
inline constexpr const char* kTimeMetadata = "t4d_time";

struct VdbFramesOptions {
  /// For densities: values above this are inside. Without it, values below zero are (level sets).
  std::optional<double> iso = {};
  bool below = false;  ///< with `iso`: values below it are inside, not above
  /// Time between two frames; overrides the times in the metadata. Where no grid has one, it is 1.
  std::optional<double> frameTime = {};
  double startTime = 0;  ///< of the first frame, with `frameTime`
  /// The time of each frame of the files, increasing; overrides all of these. Empty for none.
  std::vector<double> times = {};
  /// What is used: points of index space, whose numbers may be negative, and frames counted from 0.
  /// Positions and times stay what they are without it.
  std::optional<Region> region = {};
  std::string grid = {};  ///< use only grids with this name; "" for all
  /// The velocity of each frame, in length units per time unit: a vec3s grid, staggered or not, or
  /// three float grids with .x, _x or x after this name; "" for none. There are then
  /// `substeps` - 1 more frames between every two (advected_frames.h).
  std::string velocity = {};
  std::uint32_t substeps = 1;
  /// From how many bytes of values on a frame has them in a temporary file.
  std::size_t largeFrame = kLargeFrame;
};

/// Frames from .vdb files: either several files of one grid each, in the order given, where those
/// of a folder are in natural order of their names, frame2 before frame10; or one file whose grids
/// are the frames, in natural order of their names, and in file order if these are equal.
///
/// Inside are values below zero of float and double grids, or above `iso`, or below it; true values
/// of bool grids, active or not; active points of mask grids. A grid is read again when its frame
/// is requested; the frame uses its values without copying, or has them in a temporary file if it
/// is large.
///
/// These are errors that name the file and the grid: a file that is not VDB, or is truncated or
/// damaged as far as that can be detected (.vdb has no checksums); other types of grid; frames with
/// values mixed with frames without; a fog volume without `iso`, and `iso` for bool and mask grids;
/// transforms that are not a uniform scale with a translation, or take
/// a voxel elsewhere than the first frame's by more than rounding (kSamePlace); a
/// background that is inside; values that are not finite; a frame without a time where another has
/// one; times that do not increase; fewer than two frames. If no frame has a point inside,
/// requesting the last frame is an error.
/// Otherwise frames without inside points are allowed anywhere. With `velocity` also: frames
/// without a time; bool and mask grids; a velocity that is missing, of another type, not finite, or
/// on a lattice with another transform than a uniform scale with a translation.
Result<std::unique_ptr<FrameSource>> openVdbFrames(std::span<const std::filesystem::path> inputs,
                                                   const VdbFramesOptions& options = {});

}  // namespace t4d::voxel4d
