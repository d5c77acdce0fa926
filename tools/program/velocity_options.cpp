#include "tools/program/velocity_options.h"

#include <limits>

#include <fmt/format.h>

#include "tools/program/console.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {

CLI::Option* VelocityOptions::addTo(CLI::App& command) {
  auto* flag = command.add_flag("--velocity", velocity,
                                "Write the velocity of vertices, for motion blur and arrows");
  command
      .add_option("--max-speed", maxSpeed,
                  "Most that a vertex may move in a time unit of the mesh; faster ones are counted")
      ->check(numberAboveZero());
  return flag;
}

std::optional<std::string> VelocityOptions::misuse(const Appearance& appearance) const {
  if (!maxSpeed || isNeeded(appearance)) return std::nullopt;
  return "--max-speed: needs --velocity or --color speed";
}

std::optional<convert::FrameVelocity> VelocityOptions::ofFrames(
    const Appearance& appearance, std::vector<double> timeUnits) const {
  if (!isNeeded(appearance)) return std::nullopt;
  return convert::FrameVelocity{maxSpeed.value_or(std::numeric_limits<double>::infinity()),
                                std::move(timeUnits), velocity};
}

Result<Painting> paintingBySpeed(std::span<const model::Body> bodies, std::span<const double> times,
                                 slice::SliceDetail detail,
                                 const convert::FrameVelocity& velocity) {
  ProgressBar bar("looking for the largest speed", times.size(), "frames");
  const auto nothing = [](std::size_t, std::span<const formats::NamedMesh>) {
    return Result<void>();
  };
  const auto found =
      convert::forEachFrame(bodies, times, {detail, velocity, {}, false}, nothing, bar.callback());
  if (!found) return found.error();
  return speedPainting(found->maxSpeed);
}

std::string velocityText(const VelocityOptions& options, double maxSpeed, std::uint64_t clamped,
                         const std::string& unit) {
  if (!options.velocity) return {};
  std::string text = fmt::format("velocities in {}, at most {:.6g}", unit, maxSpeed);
  if (options.maxSpeed) {
    text += fmt::format("; {} slowed down to --max-speed", counted(clamped, "vertex", "vertices"));
  }
  return text;
}

nlohmann::json velocityJson(bool known, const nlohmann::json& value) {
  return known ? value : nullptr;
}

std::string velocityUnit(const formats::Metadata& metadata, bool ofPlayback) {
  const std::string length = metadata.lengthUnit.empty() ? "length units" : metadata.lengthUnit;
  if (ofPlayback) return length + " per second of playback";
  return length + " per " + (metadata.timeUnit.empty() ? "time unit" : metadata.timeUnit);
}

}  // namespace t4d::tools
