#include "tools/report/solid_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include "tools/report/html_page.h"

namespace t4d::tools {
namespace {

using model::Point3;

constexpr std::uint32_t kPixels = 440;  // of a side of a picture
/// Samples per side of a pixel.
constexpr std::uint32_t kSamples = 3;
/// Edges are drawn for triangles whose smallest altitude exceeds this many pixels; the smaller it
/// is, the fainter.
constexpr double kLeastAltitude = 5;
constexpr double kFullAltitude = 40;
constexpr double kEdgePixels = 0.5;

/// Rows: right, up and towards the viewer.
Eigen::Matrix3d axesOf(const View& view) {
  constexpr double kTurn = -35 * std::numbers::pi / 180;
  constexpr double kTilt = 25 * std::numbers::pi / 180;
  Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  if (view.zUp) upright << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return Eigen::AngleAxisd(kTilt, Eigen::Vector3d::UnitX()).toRotationMatrix() *
         Eigen::AngleAxisd(kTurn, Eigen::Vector3d::UnitY()).toRotationMatrix() * upright;
}

struct Sample {
  float depth = -std::numeric_limits<float>::infinity();
  float light = 0;
};

class Canvas {
 public:
  explicit Canvas(std::uint32_t pixels)
      : side_(pixels * kSamples), samples_(std::size_t{side_} * side_) {}

  double side() const { return side_; }

  /// Draws a triangle with corners in samples (x right, y down, z towards the viewer) and the given
  /// brightness.
  void draw(const std::array<Point3, 3>& p, float light, bool withEdges) {
    const Point3 u = p[1] - p[0];
    const Point3 v = p[2] - p[0];
    const double area = u.x() * v.y() - u.y() * v.x();
    if (area == 0) return;
    std::array<double, 3> altitudes{};  // in pixels, over the edge opposite the corner
    for (std::size_t i = 0; i < 3; ++i) {
      altitudes[i] = std::abs(area) / (p[(i + 2) % 3] - p[(i + 1) % 3]).head<2>().norm() / kSamples;
    }
    const double least = *std::min_element(altitudes.begin(), altitudes.end());
    const bool edges = withEdges && least > kLeastAltitude;
    const auto edgeLight =
        static_cast<float>(light * (0.8 - 0.25 * std::clamp(least / kFullAltitude, 0.0, 1.0)));
    const auto [left, right] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [top, bottom] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    for (std::int64_t y = sampleFrom(top); y < sampleFrom(bottom); ++y) {
      for (std::int64_t x = sampleFrom(left); x < sampleFrom(right); ++x) {
        const Eigen::Vector2d at(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
        std::array<double, 3> weights{};
        for (std::size_t i = 0; i < 3; ++i) {
          const Eigen::Vector2d from = p[(i + 1) % 3].head<2>();
          const Eigen::Vector2d along = p[(i + 2) % 3].head<2>() - from;
          const Eigen::Vector2d here = at - from;
          weights[i] = (along.x() * here.y() - along.y() * here.x()) / area;
        }
        if (std::any_of(weights.begin(), weights.end(), [](double w) { return w < 0; })) continue;
        const auto depth = static_cast<float>(weights[0] * p[0].z() + weights[1] * p[1].z() +
                                              weights[2] * p[2].z());
        Sample& sample =
            samples_[static_cast<std::size_t>(y) * side_ + static_cast<std::size_t>(x)];
        if (depth <= sample.depth) continue;
        sample.depth = depth;
        sample.light = light;
        for (std::size_t i = 0; edges && i < 3; ++i) {
          if (weights[i] * altitudes[i] < kEdgePixels) sample.light = edgeLight;
        }
      }
    }
  }

  /// Rows of red, green, blue and opacity: means of the samples. `colourAt` is called with points
  /// in the coordinates of `draw`.
  std::vector<std::uint8_t> pixels(const ColourAt& colourAt) const {
    const std::uint32_t pixels = side_ / kSamples;
    std::vector<std::uint8_t> bytes;
    bytes.reserve(std::size_t{pixels} * pixels * 4);
    const auto byte = [](float value) {
      return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
    };
    for (std::uint32_t y = 0; y < pixels; ++y) {
      for (std::uint32_t x = 0; x < pixels; ++x) {
        float light = 0;
        float covered = 0;
        Point3 nearest(0, 0, -std::numeric_limits<double>::infinity());
        for (std::uint32_t i = 0; i < kSamples * kSamples; ++i) {
          const std::uint32_t column = x * kSamples + i % kSamples;
          const std::uint32_t row = y * kSamples + i / kSamples;
          const Sample& sample = samples_[std::size_t{row} * side_ + column];
          if (std::isinf(sample.depth)) continue;
          covered += 1;
          light += sample.light;
          if (sample.depth > nearest.z()) nearest = {column + 0.5, row + 0.5, sample.depth};
        }
        const Colour colour = covered > 0 ? colourAt(nearest) : Colour{};
        for (const float value : colour) {
          bytes.push_back(covered > 0 ? byte(value * light / covered) : 0);
        }
        bytes.push_back(byte(covered / (kSamples * kSamples)));
      }
    }
    return bytes;
  }

 private:
  /// The first sample whose centre is at or after a coordinate, within the canvas.
  std::int64_t sampleFrom(double value) const {
    return static_cast<std::int64_t>(
        std::ceil(std::clamp(value, 0.0, static_cast<double>(side_)) - 0.5));
  }

  std::uint32_t side_;
  std::vector<Sample> samples_;
};

/// Whether most of a surface consists of triangles that are large enough for their edges to be
/// drawn; true for an empty one.
bool showsEdges(const model::TriangleMesh& mesh, const View& view) {
  const double least = kLeastAltitude * view.extent / kPixels;  // length units
  double large = 0;
  double total = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point3& p = mesh.vertices[a];
    const Point3& q = mesh.vertices[b];
    const Point3& r = mesh.vertices[c];
    const double area = 0.5 * (q - p).cross(r - p).norm();
    const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
    total += area;
    if (2 * area > least * longest) large += area;
  }
  return large >= 0.5 * total;
}

}  // namespace

void append(model::TriangleMesh& to, const model::TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const model::Triangle& triangle : mesh.triangles) {
    to.triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
  }
}

View viewOf(const model::Bounds3& bounds, bool zUp) {
  View view;
  view.zUp = zUp;
  if (bounds.empty()) return view;
  view.middle = 0.5 * (bounds.min + bounds.max);
  const Eigen::Matrix3d axes = axesOf(view);
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Point3 p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = (corner >> axis & 1) != 0 ? bounds.max[axis] : bounds.min[axis];
    }
    reach = std::max(reach, (axes * (p - view.middle)).head<2>().cwiseAbs().maxCoeff());
  }
  constexpr double kMargin = 1.06;
  if (reach > 0) view.extent = 2 * kMargin * reach;
  return view;
}

Colour blended(const Colour& from, const Colour& to, double part) {
  Colour colour{};
  for (std::size_t c = 0; c < colour.size(); ++c) {
    colour[c] = std::lerp(from[c], to[c], static_cast<float>(std::clamp(part, 0.0, 1.0)));
  }
  return colour;
}

ColourAt always(const Colour& colour) {
  return [colour](const Point3&) { return colour; };
}

std::string figureOf(const model::TriangleMesh& mesh, const ColourAt& colourAt, const View& view,
                     const std::string& caption, Shading shading) {
  Canvas canvas(kPixels);
  const bool edges = showsEdges(mesh, view);
  const Eigen::Matrix3d axes = axesOf(view);
  const double scale = canvas.side() / view.extent;
  const double half = 0.5 * canvas.side();
  std::vector<Point3> points;
  points.reserve(mesh.vertices.size());
  for (const Point3& vertex : mesh.vertices) {
    const Point3 p = scale * (axes * (vertex - view.middle));
    points.emplace_back(half + p.x(), half - p.y(), p.z());
  }
  const Eigen::Vector3d light = Eigen::Vector3d(-0.3, 0.7, 0.65).normalized();
  const bool solid = shading == Shading::Solid;
  for (const auto& [a, b, c] : mesh.triangles) {
    // y points down in `points`, which flips the normal.
    Eigen::Vector3d normal = (points[c] - points[a]).cross(points[b] - points[a]);
    normal.y() = -normal.y();
    if (!(normal.z() > 0)) continue;  // faces away, so it is hidden
    const double facing = std::max(0.0, normal.normalized().dot(light));
    const double bright = solid ? 0.52 + 0.5 * facing : 0.82 + 0.18 * facing;
    canvas.draw({points[a], points[b], points[c]}, static_cast<float>(bright), edges);
  }

  const std::vector<std::uint8_t> raw = canvas.pixels([&](const Point3& p) {
    const Point3 seen(p.x() - half, half - p.y(), p.z());
    return colourAt(view.middle + axes.transpose() * seen / scale);
  });
  std::vector<std::uint8_t> png;
  const auto append = [](void* context, void* data, int size) {
    auto& bytes = *static_cast<std::vector<std::uint8_t>*>(context);
    const auto* begin = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  };
  constexpr int side = kPixels;
  stbi_write_png_to_func(append, &png, side, side, 4, raw.data(), 4 * side);
  return figureOf(png, kPixels, caption);
}

}  // namespace t4d::tools
