#include "tools/t4d/slice_write_options.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "formats/gltf/gltf_writer.h"
#include "tools/t4d/console.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/painting.h"

namespace t4d::tools {
bool SliceWriteOptions::isColoredByAttribute() const {
  return color == "triangle" || color.starts_with(kColorByAttribute);
}

bool isSliceColor(std::string_view text) {
  constexpr std::array<std::string_view, 5> kNames = {"body", "time", "speed", "track", "triangle"};
  return std::ranges::find(kNames, text) != kNames.end() ||
         (text.starts_with(kColorByAttribute) && text.size() > kColorByAttribute.size());
}

namespace {

std::optional<formats::NormalStyle> normalStyleOf(std::string_view text) {
  constexpr std::string_view kCrease = "crease:";
  if (text == "flat") return formats::NormalStyle{.flat = true};
  if (text == "smooth") return formats::NormalStyle{};
  if (!text.starts_with(kCrease)) return std::nullopt;
  const auto degrees = numberOf(text.substr(kCrease.size()));
  if (!degrees || !(*degrees >= 0 && *degrees <= 180)) return std::nullopt;
  return formats::NormalStyle{.creaseDegrees = *degrees};
}

void addLooks(CLI::App& command, SliceWriteOptions& options) {
  command
      .add_option_function<std::string>(
          "--normals",
          [&options](const std::string& text) { options.normals = normalStyleOf(text); },
          "Write normals; crease:DEG keeps edges sharper than DEG degrees (default: none)")
      ->check(CLI::Validator(
          [](std::string& text) {
            return normalStyleOf(text) ? std::string()
                                       : fmt::format(
                                             "'{}' is not flat, smooth or crease:DEG with "
                                             "DEG from 0 to 180",
                                             text);
          },
          "flat|smooth|crease:DEG"));
  command
      .add_option("--color", options.color,
                  "Colour by body, time, speed, track, input triangle or attribute (default: none)")
      ->check(CLI::Validator(
          [](std::string& text) {
            return isSliceColor(text) ? std::string()
                                      : fmt::format(
                                            "'{}' is not body, time, speed, track, triangle or "
                                            "attribute:NAME",
                                            text);
          },
          "body|time|speed|track|triangle|attribute:NAME"));
}

}  // namespace

void addSliceWriteOptions(CLI::App& command, SliceWriteOptions& options) {
  command.add_flag("--attributes", options.attributes,
                   "Write attributes; list those that the format cannot store (exit code 3)");
  addLooks(command, options);
  command.add_flag("--velocity", options.velocity,
                   "Write the velocity of vertices, for motion blur and arrows");
  command
      .add_option("--max-speed", options.maxSpeed,
                  "Maximum speed of a vertex, in length units per time unit; faster ones are "
                  "slowed and counted")
      ->check(numberAboveZero());
  command
      .add_option("--quantize", options.quantizeBits,
                  "Bits per coordinate in glTF (KHR_mesh_quantization); 8 for normals")
      ->check(wholeNumber(1, 16));
  command.add_flag("--meshopt", options.meshopt,
                   "Compress glTF losslessly (EXT_meshopt_compression; not for Blender)");
}

std::optional<std::string> misuseOfMaxSpeed(const SliceWriteOptions& options) {
  if (!options.maxSpeed || options.needsVelocity()) return std::nullopt;
  return "--max-speed: needs --velocity or --color speed";
}

std::optional<std::string> misuseOfEncoding(const SliceWriteOptions& options,
                                            const std::string& output) {
  if (!options.quantizeBits && !options.meshopt) return std::nullopt;
  const char* option = options.quantizeBits ? "--quantize" : "--meshopt";
  if (!formats::isGltf(output)) {
    return fmt::format("{}: only .glb and .gltf are encoded so", option);
  }
  if (options.meshopt && !formats::hasMeshopt()) {
    return "--meshopt: this program was built without meshoptimizer";
  }
  return std::nullopt;
}

std::string colorText(const SliceWriteOptions& options,
                      const std::optional<std::array<double, 2>>& range) {
  const std::string ends = range ? fmt::format(", from {} to {}", (*range)[0], (*range)[1]) : "";
  if (options.isColoredBySpeed()) return "coloured by speed" + ends;
  if (!options.isColoredByAttribute()) return {};
  const std::size_t colon = options.color.find(':');
  const std::string attribute =
      colon == std::string::npos ? options.color : options.color.substr(colon + 1);
  return fmt::format("coloured by attribute '{}'{}", attribute, ends);
}

std::string velocityText(const SliceWriteOptions& options, double maxSpeed, std::uint64_t clamped,
                         const std::string& unit) {
  if (!options.velocity) return {};
  std::string text = fmt::format("velocities in {}, at most {:.6g}", unit, maxSpeed);
  if (options.maxSpeed) {
    text += fmt::format("; {} slowed down to --max-speed", counted(clamped, "vertex", "vertices"));
  }
  return text;
}

std::string velocityUnit(const formats::Metadata& metadata, bool ofPlayback) {
  const std::string length = metadata.lengthUnit.empty() ? "length units" : metadata.lengthUnit;
  if (ofPlayback) return length + " per second of playback";
  return length + " per " + (metadata.timeUnit.empty() ? "time unit" : metadata.timeUnit);
}

std::string quantizationText(const SliceWriteOptions& options, const std::optional<double>& error) {
  if (!error || !options.quantizeBits) return {};
  return fmt::format("coordinates in {} bits, each within {:.3g}", *options.quantizeBits, *error);
}

}  // namespace t4d::tools
