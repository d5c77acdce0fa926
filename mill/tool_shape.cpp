#include "mill/tool_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "model/number.h"

namespace t4d::mill {
namespace {

using Profile = std::vector<Eigen::Vector2d>;  // distance from the axis, height

constexpr double kQuarter = std::numbers::pi / 2;

/// The number of chords of an arc that stay within the tolerance; at least `least`.
double chordsOf(double radius, double angle, double tolerance, double least) {
  if (!(tolerance < radius)) return least;
  // 1 - cos of an angle is twice the square of the sine of its half.
  const double step = 4 * std::asin(std::sqrt(tolerance / (2 * radius)));
  return std::max(least, std::ceil(angle / step));
}

double chordsAround(double radius, double tolerance) {
  return chordsOf(radius, 2 * std::numbers::pi, tolerance, 8);
}

/// The number of chords of an arc of a profile, which is at most a quarter.
double chordsInProfile(double radius, double radians, double tolerance) {
  return chordsOf(radius, radians, tolerance, 2);
}

/// Fails if a solid of revolution has too many triangles within the tolerance: `widest` is a bound
/// of its radius, and its profile has an arc.
Result<void> checkTolerance(double widest, double arcRadius, double tolerance) {
  const auto trianglesFor = [&](double within) {
    constexpr double kOthers = 3;  // corners of the profile
    return 2 * chordsAround(widest, within) *
           (chordsInProfile(arcRadius, kQuarter, within) + kOthers);
  };
  constexpr auto kMost = static_cast<double>(kMostToolTriangles);
  const double triangles = trianglesFor(tolerance);
  if (triangles <= kMost) return {};
  double fitting = std::max(tolerance, std::numeric_limits<double>::epsilon() * widest);
  while (trianglesFor(fitting) > kMost) fitting *= 1.1;
  const double digit = std::pow(10, std::floor(std::log10(fitting)) - 1);
  fitting = (std::floor(fitting / digit) + 1) * digit;
  return fail(ErrorCode::Options,
              fmt::format("within a tolerance of {} the tool has {:.2g} triangles, expected at "
                          "most {}; a tolerance of {:.2g} will do",
                          tolerance, triangles, kMostToolTriangles, fitting));
}

/// A profile from the axis to the axis, counter-clockwise about the solid in (distance, height).
model::TriangleMesh revolved(const Profile& profile, double tolerance) {
  double widest = 0;
  for (const auto& point : profile) widest = std::max(widest, point.x());
  const auto around = static_cast<std::uint32_t>(chordsAround(widest, tolerance));
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

/// Adds an arc about (centre, height), from below by an angle of at most a quarter toward the side,
/// without its first point.
void addArc(Profile& profile, double centre, double height, double radius, double radians,
            double tolerance) {
  const auto chords = static_cast<int>(chordsInProfile(radius, radians, tolerance));
  for (int i = 1; i <= chords; ++i) {
    const double angle = radians * i / chords;
    const bool isSide = angle == kQuarter;
    profile.emplace_back(centre + radius * (isSide ? 1 : std::sin(angle)),
                         height - radius * (isSide ? 0 : std::cos(angle)));
  }
}

/// The sizes in `d=6,l=30`, of the letters given; 0 for those that are missing, which only the
/// optional ones may be.
Result<std::vector<double>> sizesOf(std::string_view text, std::string_view letters,
                                    std::string_view optional, std::string_view example) {
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
    if (letter != letters.npos) value = model::numberIn<double>(field.substr(2)).value_or(0);
    if (letter == letters.npos || !(value > 0) || !std::isfinite(value)) {
      return invalid(fmt::format("found '{}', expected sizes above zero as in {}", field, example));
    }
    sizes[letter] = value;
    if (comma == rest.size()) break;
    rest.remove_prefix(comma + 1);
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!(sizes[i] > 0) && optional.find(letters[i]) == optional.npos) {
      return invalid(fmt::format("'{}' has no {}; write it as in {}", text, letters[i], example));
    }
  }
  return sizes;
}

struct KnownTool {
  std::string_view word;
  ToolKind kind;
  std::string_view letters;
  std::string_view optional;
  std::string_view example;
};

constexpr std::array<KnownTool, 7> kTools = {{
    {"ball", ToolKind::Ball, "dl", "", "ball:d=6,l=30"},
    {"flat", ToolKind::Flat, "dl", "", "flat:d=6,l=30"},
    {"bull", ToolKind::Bull, "drl", "", "bull:d=6,r=1,l=30"},
    {"drill", ToolKind::Cone, "dal", "al", "drill:d=6,a=118,l=60"},
    {"vbit", ToolKind::Cone, "datl", "t", "vbit:d=6,a=60,t=0.2,l=20"},
    {"chamfer", ToolKind::Cone, "datl", "t", "chamfer:d=10,a=90,t=2,l=20"},
    {"taper", ToolKind::Taper, "dral", "dr", "taper:d=2,a=5,l=30 or taper:r=1,a=5,l=30"},
}};

constexpr double kDrillDegrees = 118;
constexpr double kDrillLength = 10;  // diameters

double radiansOf(double degrees) { return degrees * std::numbers::pi / 180; }

/// How high the lower end of a tool reaches, up to where its side begins.
double endHeight(const ToolShape& tool) {
  switch (tool.kind) {
    case ToolKind::Ball:
      return tool.diameter / 2;
    case ToolKind::Flat:
      return 0;
    case ToolKind::Bull:
      return tool.cornerRadius;
    case ToolKind::Cone:
      return (tool.diameter - tool.tipDiameter) / 2 / std::tan(radiansOf(tool.angle) / 2);
    case ToolKind::Taper:
      return tool.cornerRadius * (1 - std::sin(radiansOf(tool.angle)));
  }
  return 0;
}

Result<void> checkTool(const ToolShape& tool) {
  if (tool.kind == ToolKind::Bull && !(tool.cornerRadius < tool.diameter / 2)) {
    return invalid(
        fmt::format("the rounding r={} must be below half the diameter d={}; with half "
                    "of it this is a ball",
                    tool.cornerRadius, tool.diameter));
  }
  if (tool.kind == ToolKind::Cone && !(tool.tipDiameter < tool.diameter)) {
    return invalid(fmt::format("the tip t={} must be below the diameter d={}", tool.tipDiameter,
                               tool.diameter));
  }
  const double most = tool.kind == ToolKind::Taper ? 90 : 180;
  if (!(tool.angle < most)) {
    return invalid(fmt::format("the angle a={} must be below {} degrees", tool.angle, most));
  }
  if (tool.kind == ToolKind::Taper && (tool.diameter > 0) == (tool.cornerRadius > 0)) {
    return invalid(
        "a taper has either d, the diameter of a flat lower end, or r, the radius of a round one");
  }
  if (!(tool.length > endHeight(tool))) {
    return invalid(fmt::format("the length l={} must be more than the height {:.6g} of the {} end",
                               tool.length, endHeight(tool),
                               tool.kind == ToolKind::Cone ? "pointed" : "rounded"));
  }
  return {};
}

}  // namespace

bool namesToolKind(std::string_view text) {
  return std::ranges::any_of(kTools, [&](const KnownTool& known) {
    return text.starts_with(known.word) && text.substr(known.word.size()).starts_with(':');
  });
}

Result<ToolShape> parseTool(std::string_view text) {
  const auto colon = std::min(text.find(':'), text.size());
  const auto known = std::ranges::find(kTools, text.substr(0, colon), &KnownTool::word);
  if (known == kTools.end()) {
    return invalid(
        fmt::format("'{}' is not a tool; expected ball:, flat:, bull:, drill:, vbit:, chamfer: or "
                    "taper: and sizes, as in ball:d=6,l=30, or the file of a triangle mesh",
                    text));
  }
  const auto sizes = sizesOf(text.substr(std::min(colon + 1, text.size())), known->letters,
                             known->optional, known->example);
  if (!sizes) return sizes.error();
  const auto size = [&](char letter) {
    const auto at = known->letters.find(letter);
    return at == known->letters.npos ? 0 : (*sizes)[at];
  };
  ToolShape tool{known->kind, size('d'), size('r'), size('l'), size('a'), size('t')};
  if (known->word == "drill") {
    if (tool.angle == 0) tool.angle = kDrillDegrees;
    if (tool.length == 0) tool.length = kDrillLength * tool.diameter;
  }
  if (auto good = checkTool(tool); !good) return good.error();
  return tool;
}

Result<Cylinder> parseCylinder(std::string_view text) {
  const auto sizes = sizesOf(text, "dl", "", "d=40,l=50");
  if (!sizes) return sizes.error();
  return Cylinder{(*sizes)[0], (*sizes)[1]};
}

Result<model::TriangleMesh> toolMesh(const ToolShape& tool, double tolerance) {
  double radius = tool.diameter / 2;
  const double corner = tool.cornerRadius;
  const double arc = tool.kind == ToolKind::Ball ? radius : corner;
  const double widest = tool.kind == ToolKind::Taper
                            ? radius + corner + tool.length * std::tan(radiansOf(tool.angle))
                            : radius;
  if (auto good = checkTolerance(widest, arc, tolerance); !good) return good.error();
  Profile profile = {{0, 0}};
  switch (tool.kind) {
    case ToolKind::Flat:
      profile.emplace_back(radius, 0);
      break;
    case ToolKind::Ball:
      addArc(profile, 0, radius, radius, kQuarter, tolerance);
      break;
    case ToolKind::Bull:
      profile.emplace_back(radius - corner, 0);
      addArc(profile, radius - corner, corner, corner, kQuarter, tolerance);
      break;
    case ToolKind::Cone:
      if (tool.tipDiameter > 0) profile.emplace_back(tool.tipDiameter / 2, 0);
      profile.emplace_back(radius, endHeight(tool));
      break;
    case ToolKind::Taper: {
      const double lean = radiansOf(tool.angle);
      if (corner > 0) {
        addArc(profile, 0, corner, corner, kQuarter - lean, tolerance);
      } else {
        profile.emplace_back(radius, 0);
      }
      const Eigen::Vector2d side = profile.back();
      radius = side.x() + (tool.length - side.y()) * std::tan(lean);
      break;
    }
  }
  profile.emplace_back(radius, tool.length);
  profile.emplace_back(0, tool.length);
  return revolved(profile, tolerance);
}

Result<model::TriangleMesh> cylinderMesh(const Cylinder& cylinder, double from, double tolerance) {
  const double radius = cylinder.diameter / 2;
  if (auto good = checkTolerance(radius, 0, tolerance); !good) return good.error();
  const double to = from + cylinder.length;
  return revolved({{0, from}, {radius, from}, {radius, to}, {0, to}}, tolerance);
}

}  // namespace t4d::mill
