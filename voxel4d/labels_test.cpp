#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "measure/triangle_tree.h"
#include "t4d/frames.h"
#include "t4d/slice.h"
#include "t4d/weave.h"

/// Labels that fill space together, each woven by itself.
namespace t4d::voxel4d {
namespace {

using model::Point3;

/// The label of a lattice point in a frame; 0 is none.
using Labelling = std::function<int(const Point3& point, int frame)>;

constexpr int kCubeSize = 28;

std::vector<model::Mesh> wovenLabels(const Labelling& labelAt, int labels, int frames) {
  std::vector<model::Mesh> meshes(static_cast<std::size_t>(labels));
  constexpr std::size_t kPoints = std::size_t{kCubeSize} * kCubeSize * kCubeSize;
  for (int label = 1; label <= labels; ++label) {
    std::vector<std::unique_ptr<bool[]>> flags;
    std::vector<ArrayFrame<bool>> arrays;
    for (int frame = 0; frame < frames; ++frame) {
      bool* at = flags.emplace_back(std::make_unique<bool[]>(kPoints)).get();
      arrays.push_back({static_cast<double>(frame), {at, kPoints}});
      for (int x = 0; x < kCubeSize; ++x) {
        for (int y = 0; y < kCubeSize; ++y) {
          for (int z = 0; z < kCubeSize; ++z) *at++ = labelAt(Point3(x, y, z), frame) == label;
        }
      }
    }
    const auto source = arrayFrames<bool>(arrays, {.size = {kCubeSize, kCubeSize, kCubeSize}});
    EXPECT_TRUE(source && weave(**source, {}, meshes[static_cast<std::size_t>(label - 1)]));
  }
  return meshes;
}

/// Tells points inside a closed surface by the triangles above them.
class InsideTest {
 public:
  explicit InsideTest(const model::TriangleMesh& mesh)
      : mesh_(mesh), above_(kCubeSize * kCubeSize) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      model::Bounds3 bounds;
      for (const std::uint32_t corner : mesh.triangles[i]) bounds.add(mesh.vertices[corner]);
      for (int x = cellOf(bounds.min.x()); x <= cellOf(bounds.max.x()); ++x) {
        for (int y = cellOf(bounds.min.y()); y <= cellOf(bounds.max.y()); ++y) {
          above_[static_cast<std::size_t>(x * kCubeSize + y)].push_back(i);
        }
      }
    }
  }
  bool operator()(const Point3& point) const {
    const Eigen::Vector2d p = point.head<2>() + Eigen::Vector2d(3.1e-6, 4.7e-6);  // off edges
    int winding = 0;
    for (const std::size_t i :
         above_[static_cast<std::size_t>(cellOf(p.x()) * kCubeSize + cellOf(p.y()))]) {
      std::array<double, 3> areas{};
      double height = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Point3& a = mesh_.vertices[mesh_.triangles[i][(k + 1) % 3]];
        const Point3& b = mesh_.vertices[mesh_.triangles[i][(k + 2) % 3]];
        areas[k] = (a.x() - p.x()) * (b.y() - p.y()) - (a.y() - p.y()) * (b.x() - p.x());
        height += areas[k] * (mesh_.vertices[mesh_.triangles[i][k]].z() - point.z());
      }
      const bool up = areas[0] > 0 && areas[1] > 0 && areas[2] > 0;
      const bool down = areas[0] < 0 && areas[1] < 0 && areas[2] < 0;
      if (up && height > 0) ++winding;
      if (down && height < 0) --winding;
    }
    return winding > 0;
  }

 private:
  static int cellOf(double coordinate) {
    return std::clamp(static_cast<int>(coordinate), 0, kCubeSize - 1);
  }
  const model::TriangleMesh& mesh_;
  std::vector<std::vector<std::size_t>> above_;
};

/// An overlap that is as good as none, in voxels.
constexpr double kNoticed = 1e-3;

/// How far vertices of the one solid are in the other, at most; not less than kNoticed.
double depthIn(const model::TriangleMesh& other, const model::TriangleMesh& solid) {
  const measure::TriangleTree tree(other);
  const InsideTest inside(other);
  double depth = kNoticed;
  for (const Point3& vertex : solid.vertices) {
    const double distance = tree.nearest(vertex).distance;
    if (distance > depth && inside(vertex)) depth = distance;
  }
  return depth;
}

/// How far one of them is in another at most, at times between the frames.
double deepestOverlap(const Labelling& labelAt, int labels, int frames) {
  const auto meshes = wovenLabels(labelAt, labels, frames);
  double deepest = 0;
  for (double time = 0.17; time < frames - 1; time += 0.29) {
    std::vector<model::TriangleMesh> slices;
    for (const model::Mesh& mesh : meshes) {
      const auto slice = slice::sliceAtTime(mesh, time);
      if (slice && !slice->mesh.triangles.empty()) slices.push_back(slice->mesh);
    }
    for (const model::TriangleMesh& a : slices) {
      for (const model::TriangleMesh& b : slices) {
        if (&a != &b) deepest = std::max(deepest, depthIn(a, b));
      }
    }
  }
  return deepest;
}

const Point3 kMiddle(13.3, 13.7, 13.1);

double fromMiddle(const Point3& point) { return (point - kMiddle).norm(); }

TEST(WeaveLabels, HalvesOfAMovingBallDoNotOverlap) {
  for (const int axis : {0, 1}) {
    const auto halves = [=](const Point3& point, int frame) {
      const Point3 centre = kMiddle + Point3(2 * frame - 2, 0, 0);
      if ((point - centre).norm() > 8) return 0;
      return point[axis] < centre[axis] ? 1 : 2;
    };
    EXPECT_LE(deepestOverlap(halves, 2, 3), kNoticed);
  }
}

TEST(WeaveLabels, ALabelThatTakesThePlaceOfAnotherOverlapsItByLessThanAVoxel) {
  for (const Point3& offset : {Point3(0, 0, 0), Point3(3, 0, 0), Point3(8, 1, -2)}) {
    const auto takesOver = [=](const Point3& point, int frame) {
      if (fromMiddle(point) > 10) return 0;
      return frame == 1 && fromMiddle(point - offset) < 6 ? 2 : 1;
    };
    EXPECT_LT(deepestOverlap(takesOver, 2, 2), 1) << offset.transpose();
  }
}

TEST(WeaveLabels, LabelsThatMoveGrowAndVanishOverlapByLessThanAVoxel) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    // Points have the label of the nearest ball.
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    struct Ball {
      Point3 centre;
      Eigen::Vector3d velocity;
      double radius;
      double growth;
    };
    std::vector<Ball> balls(3);
    for (Ball& ball : balls) {
      for (double& x : ball.centre) x = 13 + 5 * unit(random);
      for (double& x : ball.velocity) x = 3 * unit(random);
      ball.radius = 6 + 2 * unit(random);
      ball.growth = 2 * unit(random);
    }
    const auto nearestBall = [=](const Point3& point, int frame) {
      const auto distance = [&](const Ball& ball) {
        return (point - ball.centre - frame * ball.velocity).norm();
      };
      const auto nearest = std::ranges::min_element(balls, {}, distance);
      if (distance(*nearest) > nearest->radius + nearest->growth * frame) return 0;
      return 1 + static_cast<int>(nearest - balls.begin());
    };
    EXPECT_LT(deepestOverlap(nearestBall, 3, 3), 1) << seed;
  }
}

TEST(WeaveLabels, NoiseOverlapsByLessThanAVoxel) {
  for (unsigned seed = 0; seed < 2; ++seed) {
    const auto noise = [=](const Point3& point, int frame) {
      if (fromMiddle(point) > 6) return 0;
      const double place = (point.x() * 32 + point.y()) * 32 + point.z() + 32768 * frame;
      return 1 + static_cast<int>(std::mt19937(static_cast<unsigned>(place) + (seed << 20))() % 3);
    };
    EXPECT_LT(deepestOverlap(noise, 3, 2), 1) << seed;
  }
}

}  // namespace
}  // namespace t4d::voxel4d
