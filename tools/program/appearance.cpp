#include "tools/program/appearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "t4d/slice/velocity.h"
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

constexpr std::string_view kAttribute = "attribute:";

convert::Paint bodyPaint(const formats::Metadata& metadata) {
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
  return [colors](formats::NamedMesh& mesh, double) {
    const auto found = colors.find(mesh.name);
    if (found != colors.end()) mesh.color = found->second;
  };
}

}  // namespace

void Appearance::addTo(CLI::App& command) {
  command
      .add_option("--normals", normals,
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
      .add_option("--color", color,
                  "Colour by body, time, speed, input triangle or attribute (default: none)")
      ->check(CLI::Validator(
          [](std::string& text) {
            const bool known = text == "body" || text == "time" || text == "speed" ||
                               text == "triangle" ||
                               (text.starts_with(kAttribute) && text.size() > kAttribute.size());
            return known ? std::string()
                         : fmt::format("'{}' is not body, time, speed, triangle or attribute:NAME",
                                       text);
          },
          "body|time|speed|triangle|attribute:NAME"));
}

std::string Painting::text() const {
  if (!attribute) return {};
  if (attribute->magnitude) {
    return fmt::format("coloured by speed, from 0 to {}", attribute->high);
  }
  if (attribute->distinct || attribute->components > 1) {
    return fmt::format("coloured by attribute '{}'", attribute->attribute);
  }
  return fmt::format("coloured by attribute '{}', from {} to {}", attribute->attribute,
                     attribute->low, attribute->high);
}

nlohmann::json Painting::range() const {
  if (!attribute || attribute->distinct) return nullptr;
  if (attribute->components > 1 && !attribute->magnitude) return nullptr;
  return {attribute->low, attribute->high};
}

Painting speedPainting(double largest) {
  const convert::AttributeColors colors{.attribute = std::string(slice::kVelocity),
                                        .components = 3,
                                        .magnitude = true,
                                        .high = largest};
  return {[colors](formats::NamedMesh& mesh, double) { colors.paint(mesh); }, colors};
}

std::optional<formats::NormalStyle> Appearance::normalStyle() const {
  return normalStyleOf(normals);
}

template <class Element>
Result<Painting> Appearance::paintingOf(const formats::Metadata& metadata,
                                        const model::TimeSpan& span,
                                        std::span<const Element> elements) const {
  if (color.empty()) return Painting();
  if (color == "body") return Painting{bodyPaint(metadata), {}};
  if (color == "time") {
    return Painting{[span](formats::NamedMesh& mesh, double time) {
                      const double length = span.end - span.begin;
                      mesh.color =
                          convert::rampColor(length > 0 ? (time - span.begin) / length : 0);
                    },
                    {}};
  }
  const bool distinct = color == "triangle";
  auto colors = convert::attributeColors(distinct ? color : color.substr(kAttribute.size()),
                                         distinct, elements);
  if (!colors) return colors.error();
  const auto shared = std::make_shared<const convert::AttributeColors>(*colors);
  return Painting{[shared](formats::NamedMesh& mesh, double) { shared->paint(mesh); },
                  std::move(*colors)};
}

Result<Painting> Appearance::painting(const formats::Metadata& metadata,
                                      const model::TimeSpan& span,
                                      std::span<const model::Body> bodies) const {
  return paintingOf(metadata, span, bodies);
}

Result<Painting> Appearance::painting(const formats::Metadata& metadata,
                                      const model::TimeSpan& span,
                                      std::span<const formats::NamedMesh> meshes) const {
  return paintingOf(metadata, span, meshes);
}

}  // namespace t4d::tools
