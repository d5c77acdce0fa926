#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/convert.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/slice_write_options.h"

namespace t4d::tools {

class Members;

enum class FlipbookKind : std::uint8_t {
  Frames,  ///< a mesh per frame (convert::writeFlipbook), for any solid
  Rigid,   ///< a mesh per body and its poses (convert::writeRigidFlipbook)
  Morph,   ///< a mesh per body and its shapes at layers (convert::writeMorphFlipbook)
};

struct FlipbookOptions {
  std::string output = {};  ///< the .glb, .gltf, .usda or .usdz to write
  /// The times of the frames; none for 60, evenly spaced over the whole time. A flipbook without
  /// frames shows the time from the first to the last.
  std::vector<double> times = {};
  /// The rate of playback; none for as many frames as `seconds` take.
  std::optional<double> framesPerSecond = {};
  /// The duration of playback. Without it and framesPerSecond, evenly spaced frames of a mesh whose
  /// time unit is the second play in real time, and all others 24 per second.
  std::optional<double> seconds = {};
  FlipbookKind kind = FlipbookKind::Frames;
  bool exact = false;  ///< of frames: as slice::SliceDetail::Exact, not Light
  /// Velocities are per second of playback. A flipbook without frames has one colour per body, the
  /// attributes of the first time, and no velocities; shapes have at most 15 bits per coordinate,
  /// poses float32.
  SliceWriteOptions write = {};
  bool visibility = false;  ///< of frames in glTF: as formats::GltfEncoding::visibility
};

struct FlipbookReport {
  FlipbookKind kind = FlipbookKind::Frames;
  convert::FrameSlicesReport written;  ///< its notices have also gone to the observer
  double firstTime = 0;
  double lastTime = 0;
  double seconds = 0;        ///< of playback
  bool inRealTime = false;   ///< a second of playback is a second of the mesh
  std::uint64_t bytes = 0;   ///< of all files
  bool hasVelocity = false;  ///< whether velocities were written, or needed for colours
  /// The smallest and largest value of what gives colours, if they come from numbers.
  std::optional<std::array<double, 2>> colorRange = {};
  std::optional<double> quantizationError = {};  ///< how far a coordinate may be from its place
};

/// Writes a 4D mesh as an animation. Fails with Remedy::MoreFrames for velocities of one frame, and
/// if convert does.
Result<FlipbookReport> flipbook(const Input& input, const FlipbookOptions& options,
                                Observer& observer = nobody());

void describe(Members& members, const FlipbookReport& report);

}  // namespace t4d::tools
