#include "convert/attribute_colors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/triangle/written_mesh.h"

namespace t4d::convert {
namespace {

using formats::Color;
using model::Attribute;
using model::ScalarType;

constexpr Color kNoColor = {0.5, 0.5, 0.5, 1};

double linearOf(double sRgb) {
  // The curve is that of IEC 61966-2-1.
  return sRgb <= 0.04045 ? sRgb / 12.92 : std::pow((sRgb + 0.055) / 1.055, 2.4);
}

/// Five colours of viridis, in sRGB.
constexpr std::array<std::array<int, 3>, 5> kViridis = {
    {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};

bool isWhole(ScalarType type) { return type != ScalarType::Float32 && type != ScalarType::Float64; }

/// The range of an attribute, complete after all its rows.
class Range {
 public:
  Range(std::string attribute, bool distinct) : name_(std::move(attribute)), distinct_(distinct) {}

  void add(const Attribute& attribute) {
    if (attribute.name != name_) {
      if (std::ranges::find(others_, attribute.name) == others_.end()) {
        others_.push_back(attribute.name);
      }
      return;
    }
    if (attribute.rows() == 0) return;
    if (components_ == 0) components_ = attribute.components;
    if (why_.empty()) why_ = whyNot(attribute);
    if (attribute.components != 1 || distinct_) return;
    for (std::size_t row = 0; row < attribute.rows(); ++row) {
      const double number = formats::attributeNumber(attribute, row, 0);
      if (!std::isfinite(number)) continue;
      low_ = std::min(low_, number);
      high_ = std::max(high_, number);
    }
  }

  Result<AttributeColors> colors() const {
    if (components_ == 0) {
      return invalid(fmt::format("there is no attribute '{}'; {}", name_,
                                 others_.empty()
                                     ? "the mesh has none"
                                     : fmt::format("there is {}", fmt::join(others_, ", "))));
    }
    if (!why_.empty()) return invalid(fmt::format("attribute '{}' {}", name_, why_));
    const bool any = low_ <= high_;
    return AttributeColors{.attribute = name_,
                           .distinct = distinct_,
                           .components = components_,
                           .low = any ? low_ : 0,
                           .high = any ? high_ : 0};
  }

 private:
  std::string whyNot(const Attribute& attribute) const {
    const std::uint32_t components = attribute.components;
    if (components != components_) return "has another number of components elsewhere";
    if (distinct_) {
      return components == 1 && isWhole(attribute.type) ? "" : "is not a whole number";
    }
    if (components == 1) return {};
    if (components != 3 && components != 4) {
      return fmt::format("has {} components, expected 1, or 3 or 4 for colours", components);
    }
    return !isWhole(attribute.type) || attribute.type == ScalarType::UInt8 ||
                   attribute.type == ScalarType::UInt16
               ? ""
               : "has whole numbers for colours, expected UInt8 or UInt16";
  }

  std::string name_;
  bool distinct_;
  std::uint32_t components_ = 0;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
  std::string why_;
  std::vector<std::string> others_;
};

/// Adds the attributes of slabs, those of a shared connectivity once.
class RangeSink : public model::Sink {
 public:
  explicit RangeSink(Range& range) : range_(range) {}

  Result<void> put(const model::Slab& slab) override {
    for (const Attribute& attribute : slab.attributes) range_.add(attribute);
    if (slab.connectivity == last_) return {};
    last_ = slab.connectivity;
    for (const Attribute& attribute : slab.connectivity->cellAttributes) range_.add(attribute);
    return {};
  }

 private:
  Range& range_;
  std::shared_ptr<const model::Connectivity> last_;
};

/// The number that gives a row its colour.
double numberOf(const AttributeColors& how, const Attribute& attribute, std::size_t row) {
  if (!how.magnitude) return formats::attributeNumber(attribute, row, 0);
  double squares = 0;
  for (std::uint32_t i = 0; i < how.components; ++i) {
    squares += std::pow(formats::attributeNumber(attribute, row, i), 2);
  }
  return std::sqrt(squares);
}

Color colorOf(const AttributeColors& how, const Attribute& attribute, std::size_t row) {
  if (how.components == 1 || how.magnitude) {
    const double number = numberOf(how, attribute, row);
    if (!std::isfinite(number)) return kNoColor;
    if (how.distinct) {
      const bool ofCap = how.attribute == "triangle" && number == 0xffffffff;
      return ofCap ? kNoColor : distinctColor(static_cast<std::uint64_t>(std::abs(number)));
    }
    return rampColor(
        how.high > how.low ? number / (how.high - how.low) - how.low / (how.high - how.low) : 0);
  }
  Color color = {0, 0, 0, 1};
  for (std::uint32_t i = 0; i < how.components; ++i) {
    double number = formats::attributeNumber(attribute, row, i);
    if (!std::isfinite(number)) return kNoColor;
    if (attribute.type == ScalarType::UInt8) {
      number /= 255;
      if (i < 3) number = linearOf(number);
    }
    if (attribute.type == ScalarType::UInt16) number /= 65535;
    color[i] = std::clamp(number, 0.0, 1.0);
  }
  return color;
}

}  // namespace

Color rampColor(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (kViridis.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  const double weight = at - static_cast<double>(below);
  Color color = {0, 0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = linearOf(kViridis[below][i] / 255.0);
    const double b = linearOf(kViridis[below + 1][i] / 255.0);
    color[i] = a + weight * (b - a);
  }
  return color;
}

Color distinctColor(std::uint64_t number) {
  // Steps of the golden ratio round the circle of hues leave no two neighbours close together.
  constexpr double kGolden = 0.6180339887498949;
  double whole = 0;
  const double hue = 6 * std::modf(static_cast<double>(number) * kGolden, &whole);
  Color color = {0, 0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const double from = std::abs(std::fmod(hue + 6 - 2 * static_cast<double>(i), 6) - 3);
    color[i] = linearOf(0.35 + 0.55 * std::clamp(from - 1, 0.0, 1.0));
  }
  return color;
}

void AttributeColors::paint(formats::NamedMesh& named) const {
  for (const Attribute& of : named.mesh.attributes) {
    if (of.name != attribute || of.components != components) continue;
    formats::MeshColors colors{of.domain, {}};
    colors.colors.reserve(of.rows());
    for (std::size_t row = 0; row < of.rows(); ++row) {
      const Color color = colorOf(*this, of, row);
      colors.colors.push_back({static_cast<float>(color[0]), static_cast<float>(color[1]),
                               static_cast<float>(color[2]), static_cast<float>(color[3])});
    }
    named.colors = std::move(colors);
    return;
  }
}

Result<AttributeColors> attributeColors(const std::string& attribute, bool distinct,
                                        std::span<const formats::NamedMesh> meshes) {
  const auto isEmpty = [](const formats::NamedMesh& named) { return named.mesh.triangles.empty(); };
  if (std::ranges::all_of(meshes, isEmpty)) {
    return AttributeColors{.attribute = attribute, .distinct = distinct, .high = 0};
  }
  Range range(attribute, distinct);
  for (const formats::NamedMesh& named : meshes) {
    for (const Attribute& of : named.mesh.attributes) range.add(of);
  }
  return range.colors();
}

Result<AttributeColors> attributeColors(const std::string& attribute, bool distinct,
                                        std::span<const model::Body> bodies,
                                        const model::Progress& progress) {
  Range range(attribute, distinct);
  for (const model::Body& body : bodies) {
    RangeSink sink(range);
    if (auto done = model::pump(*body.source, sink, progress); !done) return done.error();
  }
  return range.colors();
}

}  // namespace t4d::convert
