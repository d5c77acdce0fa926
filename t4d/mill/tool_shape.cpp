#include "t4d/mill/tool_shape.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace t4d::mill {
namespace {

using Profile = std::vector<Eigen::Vector2d>;  // distance from the axis, height

/// The number of chords of an arc that stay within the tolerance; at least `least`.
int chordsOf(double radius, double angle, double tolerance, int least) {
  constexpr double kMost = 100'000;
  if (!(tolerance < radius)) return least;
  const double step = 2 * std::acos(1 - tolerance / radius);
  return std::max(least, static_cast<int>(std::min(kMost, std::ceil(angle / step))));
}

/// A profile from the axis to the axis, counter-clockwise about the solid in (distance, height).
model::TriangleMesh revolved(const Profile& profile, double tolerance) {
  double widest = 0;
  for (const auto& point : profile) widest = std::max(widest, point.x());
  const auto around =
      static_cast<std::uint32_t>(chordsOf(widest, 2 * std::numbers::pi, tolerance, 8));
  model::TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, profile.front().y());
  const auto rings = static_cast<std::uint32_t>(profile.size() - 2);
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    const Eigen::Vector2d& at = profile[ring + 1];
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.vertices.emplace_back(at.x() * std::cos(angle), at.x() * std::sin(angle), at.y());
    }
  }
  mesh.vertices.emplace_back(0, 0, profile.back().y());
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around;
    const auto on = [&](std::uint32_t ring, std::uint32_t k) { return 1 + ring * around + k; };
    mesh.triangles.push_back({0, on(0, next), on(0, i)});
    for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({on(ring, i), on(ring, next), on(ring + 1, next)});
      mesh.triangles.push_back({on(ring, i), on(ring + 1, next), on(ring + 1, i)});
    }
    mesh.triangles.push_back({on(rings - 1, i), on(rings - 1, next), last});
  }
  return mesh;
}

/// Adds a quarter of a circle about (centre, height), from below to the side, without its first
/// point.
void addQuarter(Profile& profile, double centre, double height, double radius, double tolerance) {
  const int chords = chordsOf(radius, std::numbers::pi / 2, tolerance, 2);
  for (int i = 1; i <= chords; ++i) {
    const double angle = std::numbers::pi / 2 * i / chords;
    const bool end = i == chords;
    profile.emplace_back(centre + radius * (end ? 1 : std::sin(angle)),
                         height - radius * (end ? 0 : std::cos(angle)));
  }
}

/// The sizes in `d=6,l=30`, of the letters given; 0 for those that are missing.
Result<std::vector<double>> sizesOf(std::string_view text, std::string_view letters,
                                    std::string_view example) {
  std::vector<double> sizes(letters.size(), 0);
  std::string_view rest = text;
  while (true) {
    const auto comma = std::min(rest.find(','), rest.size());
    const std::string_view field = rest.substr(0, comma);
    const auto equals = field.find('=');
    const auto letter = equals == 1 ? letters.find(field[0]) : letters.npos;
    if (equals != field.npos && equals > 0 && letter == letters.npos) {
      return invalid(fmt::format("'{}' is not known here; write it as in {}",
                                 field.substr(0, equals), example));
    }
    if (letter != letters.npos && sizes[letter] > 0) {
      return invalid(fmt::format("'{}' gives {} twice", text, letters[letter]));
    }
    double value = 0;
    if (letter != letters.npos) {
      const auto [stopped, problem] =
          std::from_chars(field.data() + 2, field.data() + field.size(), value);
      if (problem != std::errc{} || stopped != field.data() + field.size()) value = 0;
    }
    if (letter == letters.npos || !(value > 0) || !std::isfinite(value)) {
      return invalid(fmt::format("found '{}', expected sizes above zero as in {}", field, example));
    }
    sizes[letter] = value;
    if (comma == rest.size()) break;
    rest.remove_prefix(comma + 1);
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!(sizes[i] > 0)) {
      return invalid(fmt::format("'{}' has no {}; write it as in {}", text, letters[i], example));
    }
  }
  return sizes;
}

}  // namespace

Result<ToolShape> parseTool(std::string_view text) {
  const auto colon = std::min(text.find(':'), text.size());
  const std::string_view kind = text.substr(0, colon);
  const std::string_view rest = text.substr(std::min(colon + 1, text.size()));
  ToolShape tool;
  if (kind == "ball" || kind == "flat") {
    tool.kind = kind == "ball" ? ToolKind::Ball : ToolKind::Flat;
    const auto sizes = sizesOf(rest, "dl", fmt::format("{}:d=6,l=30", kind));
    if (!sizes) return pass(sizes.error());
    tool.diameter = (*sizes)[0];
    tool.length = (*sizes)[1];
  } else if (kind == "bull") {
    tool.kind = ToolKind::Bull;
    const auto sizes = sizesOf(rest, "drl", "bull:d=6,r=1,l=30");
    if (!sizes) return pass(sizes.error());
    tool.diameter = (*sizes)[0];
    tool.cornerRadius = (*sizes)[1];
    tool.length = (*sizes)[2];
  } else {
    return invalid(
        fmt::format("'{}' is no tool; expected ball:, flat: or bull: and sizes, as in "
                    "ball:d=6,l=30, or the file of a triangle mesh",
                    text));
  }
  if (tool.kind == ToolKind::Bull && !(tool.cornerRadius < tool.diameter / 2)) {
    return invalid(
        fmt::format("the rounding r={} must be below half the diameter d={}; with half "
                    "of it this is a ball",
                    tool.cornerRadius, tool.diameter));
  }
  const double rounding = tool.kind == ToolKind::Ball ? tool.diameter / 2 : tool.cornerRadius;
  if (!(tool.length > rounding)) {
    return invalid(fmt::format("the length l={} must be more than the height {} of the rounded end",
                               tool.length, rounding));
  }
  return tool;
}

Result<Cylinder> parseCylinder(std::string_view text) {
  const auto sizes = sizesOf(text, "dl", "d=40,l=50");
  if (!sizes) return pass(sizes.error());
  return Cylinder{(*sizes)[0], (*sizes)[1]};
}

model::TriangleMesh toolMesh(const ToolShape& tool, double tolerance) {
  const double radius = tool.diameter / 2;
  Profile profile = {{0, 0}};
  switch (tool.kind) {
    case ToolKind::Flat:
      profile.emplace_back(radius, 0);
      break;
    case ToolKind::Ball:
      addQuarter(profile, 0, radius, radius, tolerance);
      break;
    case ToolKind::Bull:
      profile.emplace_back(radius - tool.cornerRadius, 0);
      addQuarter(profile, radius - tool.cornerRadius, tool.cornerRadius, tool.cornerRadius,
                 tolerance);
      break;
  }
  profile.emplace_back(radius, tool.length);
  profile.emplace_back(0, tool.length);
  return revolved(profile, tolerance);
}

model::TriangleMesh cylinderMesh(const Cylinder& cylinder, double from, double tolerance) {
  const double radius = cylinder.diameter / 2;
  const double to = from + cylinder.length;
  return revolved({{0, from}, {radius, from}, {radius, to}, {0, to}}, tolerance);
}

}  // namespace t4d::mill
