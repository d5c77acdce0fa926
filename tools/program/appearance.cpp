#include "tools/program/appearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "tools/program/numbers.h"

namespace t4d::tools {
namespace {

using formats::Color;

constexpr std::string_view kCrease = "crease:";

std::optional<formats::NormalStyle> normalStyleOf(std::string_view text) {
  if (text == "flat") return formats::NormalStyle{.flat = true};
  if (text == "smooth") return formats::NormalStyle{};
  if (!text.starts_with(kCrease)) return std::nullopt;
  const auto degrees = numberOf(text.substr(kCrease.size()));
  if (!degrees || !(*degrees >= 0 && *degrees <= 180)) return std::nullopt;
  return formats::NormalStyle{.creaseDegrees = *degrees};
}

/// 0xrrggbb in sRGB.
Color linearOf(std::uint32_t sRgb) {
  Color color = {0, 0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = static_cast<double>(sRgb >> (16 - 8 * i) & 0xff) / 255;
    color[i] = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  }
  return color;
}

/// Well apart, also for the colour-blind (Okabe and Ito).
constexpr std::array<std::uint32_t, 7> kBodyPalette = {0xe69f00, 0x56b4e9, 0x009e73, 0xf0e442,
                                                       0x0072b2, 0xd55e00, 0xcc79a7};

/// Five colours of viridis: brightness rises evenly.
constexpr std::array<std::uint32_t, 5> kTimeRamp = {0x440154, 0x3b528b, 0x21918c, 0x5ec962,
                                                    0xfde725};

Color timeColorAt(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (kTimeRamp.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kTimeRamp.size() - 2);
  const double weight = at - static_cast<double>(below);
  const Color a = linearOf(kTimeRamp[below]);
  const Color b = linearOf(kTimeRamp[below + 1]);
  Color color{};
  for (std::size_t i = 0; i < color.size(); ++i) color[i] = a[i] + weight * (b[i] - a[i]);
  return color;
}

}  // namespace

void Appearance::addTo(CLI::App& command) {
  command
      .add_option("--normals", normals,
                  "Write normals: flat, smooth, or smooth but for edges sharper than an angle in "
                  "degrees (default: none)")
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
      .add_option("--color", color,
                  "Colour by body (those that the file says, or else a palette) or by time")
      ->check(CLI::IsMember({"body", "time"}));
}

std::optional<formats::NormalStyle> Appearance::normalStyle() const {
  return normalStyleOf(normals);
}

convert::BodyColor Appearance::bodyColor(const formats::Metadata& metadata,
                                         const model::TimeSpan& span) const {
  if (color == "time") {
    return [span](const std::string&, double time) -> std::optional<Color> {
      const double length = span.end - span.begin;
      return timeColorAt(length > 0 ? (time - span.begin) / length : 0);
    };
  }
  if (color != "body") return {};
  std::map<std::string, Color> colors;
  for (std::size_t i = 0; i < metadata.bodies.size(); ++i) {
    const formats::BodyInfo& body = metadata.bodies[i];
    Color own = linearOf(kBodyPalette[i % kBodyPalette.size()]);
    if (!body.color.empty()) {
      own[3] = 1;
      std::copy_n(body.color.begin(), std::min(body.color.size(), own.size()), own.begin());
    }
    colors[body.name] = own;
  }
  return [colors](const std::string& body, double) -> std::optional<Color> {
    const auto found = colors.find(body);
    return found == colors.end() ? std::nullopt : std::optional(found->second);
  };
}

}  // namespace t4d::tools
