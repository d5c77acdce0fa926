#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/convert/frame_slices.h"
#include "t4d/model/body.h"
#include "tools/program/appearance.h"

namespace t4d::tools {

/// The velocity of slices: `--velocity`, `--max-speed`, and what `--color speed` needs of it.
struct VelocityOptions {
  bool velocity = false;
  std::optional<double> maxSpeed;

  CLI::Option* addTo(CLI::App& command);

  /// The error message if there is a limit and nothing that it limits.
  std::optional<std::string> misuse(const Appearance& appearance) const;
  bool isNeeded(const Appearance& appearance) const { return velocity || appearance.isBySpeed(); }
  /// Of frames, if it is needed; per time unit of the mesh if `timeUnits` is empty.
  std::optional<convert::FrameVelocity> ofFrames(const Appearance& appearance,
                                                 std::vector<double> timeUnits) const;
};

/// Colours by speed from 0 to the largest of all frames, which are sliced once for it.
Result<Painting> paintingBySpeed(std::span<const model::Body> bodies, std::span<const double> times,
                                 slice::SliceDetail detail, const convert::FrameVelocity& velocity);

/// What is said of velocities per `unit`; "" if none are written.
std::string velocityText(const VelocityOptions& options, double maxSpeed, std::uint64_t clamped,
                         const std::string& unit);

/// What is known of velocities, for JSON: null if there are none.
nlohmann::json velocityJson(bool known, const nlohmann::json& value);

/// The unit of velocities: of lengths in a second of playback or, otherwise, in a time unit.
std::string velocityUnit(const formats::Metadata& metadata, bool ofPlayback);

}  // namespace t4d::tools
