#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/layer_pose.h"
#include "platform/file_format.h"
#include "voxel4d/frame.h"
#include "voxel4d/region.h"

namespace t4d::voxel4d {

/// What openVolumeFrames reads: arrays of samples, as scanners and simulations write them.
std::vector<platform::FileFormat> volumeFormats();

/// The extensions of all of these, with their dots.
std::vector<std::string_view> volumeExtensions();

/// Whether a file is one of these, by its extension.
bool isVolumeFile(const std::filesystem::path& path);

class InputBytes;

struct VolumeOptions {
  /// Samples above this are inside. Without it, and without `label`, floats below zero are inside
  /// (level sets), and bools that are true.
  std::optional<double> iso = {};
  bool below = false;  ///< with `iso`: samples below it are inside, not above
  /// Samples of this value are no data and lie outside, like everything beyond the samples. NaN
  /// stands for all samples that are not numbers. Not with `label` and not for bools.
  std::optional<double> outside = {};
  /// Samples of exactly this value are inside; their surface lies at the midpoints.
  std::optional<std::int64_t> label = {};
  /// Time between two frames; overrides what the file says.
  std::optional<double> frameTime = {};
  std::optional<double> startTime = {};  ///< of the first frame; overrides what the file says
  /// The time of each frame of the files, increasing; overrides all of these. Empty for none.
  std::vector<double> times = {};
  /// Edge lengths of a voxel, along the axes of the file, and position of the first sample;
  /// they override what the file says.
  std::optional<std::array<double, 3>> spacing = {};
  std::optional<std::array<double, 3>> origin = {};
  std::string axes = {};  ///< what the axes of a .npy array are, as "txyz"; "" for that or "xyz"
  /// What is read: samples along x, y and z, and frames, all counted from 0. Positions and times
  /// stay what they are without it.
  std::optional<Region> region = {};
  /// Whether samples are values, such as velocities, that say nothing of what is inside: numbers of
  /// any type and sign.
  bool valuesAlone = false;
  /// What the file `-` is (volumes/frame_stream.h); null: standard input, which is read once.
  std::shared_ptr<InputBytes> input = {};
  std::string raw = {};  ///< what a .raw file without a header holds: "raw float32 64 64 64 10"
};

/// Frames of samples and where they are. Where the voxels are cubes along the axes, the lattice of
/// `frames` says so. Otherwise it has voxels of 1 at the origin, and `toSpace` maps its points to
/// space, which may turn the mesh inside out: see model::Transformed.
struct VolumeFrames {
  std::unique_ptr<FrameSource> frames;
  std::optional<model::Affine3x4> toSpace;
  std::array<std::uint64_t, 3> sizes = {};  ///< samples along x, y and z
  bool takenAsDistances = false;            ///< floats, of which those below 0 are inside
  /// What positions are relative to a patient, "RAS" (x to the right, y anterior, z superior) or
  /// "LPS"; "" if the file does not say. NRRD's left-handed spaces are mirrored, which `notice`
  /// says.
  std::string space;
  std::string notice;  ///< "" for nothing
  /// Axes of x, y and z along which nothing says how large a voxel is: it is taken as 1.
  std::string unsized;
  /// The axes of the data in the order in which they are taken, as "txyz", if nothing names them.
  std::string assumedAxes;
  std::string lengthUnit;  ///< "" if the file does not say
  std::string timeUnit;
  std::string name;                 ///< of the data, if it is not that of the file; else ""
  std::vector<std::string> notes;   ///< what was assumed when the data were read
  std::vector<std::string> losses;  ///< what was left out then
};

/// Frames from volumes: one file with an axis of time, or several of a frame each, in the order
/// given, or `-`, a stream of frames (volumes/frame_stream.h). Everything beyond the samples is
/// outside. A frame is read when it is requested, and then is in memory as float, or as double if
/// its samples are wider than that or scaled. A file in which time is not the slowest axis is read
/// at once, into a temporary file of the size of its samples. Without a time between frames they
/// are 1 apart. Files of a frame each may place it differently by rounding (kSamePlace); all are
/// taken to be where the first is.
///
/// These are errors that name the file: what its header says is damaged, contradicts the size of
/// the file, or is beyond what is read (volumes/headers.h); integers with neither `iso` nor
/// `label`; samples that are not finite; a region that is not within the samples; voxels without
/// volume; files of one series that differ; fewer than two frames, or more than kMaxFrames. If no
/// frame has a sample inside, requesting the last frame is an error.
Result<VolumeFrames> openVolumeFrames(std::span<const std::filesystem::path> files,
                                      const VolumeOptions& options = {});

}  // namespace t4d::voxel4d
