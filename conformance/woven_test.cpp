#include <cmath>
#include <iostream>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "t4d/check.h"
#include "t4d/convert.h"
#include "t4d/slice.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

/// Properties of every solid woven from voxels: closed whatever happens to its topology, slices of
/// the right topology, volumes that converge.
namespace t4d::slice {
namespace {

struct Woven {
  model::Mesh mesh;
  measure::MeshReport report;
};

/// The field sampled every `voxelSize`, at `frames` times, and woven.
Woven wovenFrom(const fixtures::Field& field, double voxelSize, std::size_t frames,
                bool links = false) {
  // Offset from the origin by irregular fractions of a voxel, so that nothing coincides by chance.
  const voxel4d::Lattice lattice{voxelSize, voxelSize * model::Point3(0.17, 0.31, 0.23)};
  const auto source = voxel4d::sampledFrames(
      field.value, field.slope == 0 ? voxel4d::Lattice{} : lattice, field.box,
      model::evenTimes({field.timeBegin, field.timeEnd}, frames), {.slope = field.slope});
  Woven woven;
  const auto report = voxel4d::weave(*source, {}, woven.mesh);
  EXPECT_TRUE(report) << report.error().text();
  woven.report = *measure::checkMesh(woven.mesh, {.vertexLinks = links});
  EXPECT_TRUE(woven.report.closed && woven.report.oriented) << field.name;
  EXPECT_EQ(woven.report.issues.errors, 0U) << field.name;
  EXPECT_EQ(woven.report.degenerateCells, 0U) << field.name;
  return woven;
}

struct SurfaceTopology {
  int components = 0;
  int genus = 0;  // total over all components
};

/// The formula is V - E + F = 2 (components - genus) of a closed surface.
SurfaceTopology topologyOf(const model::TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::set<std::uint32_t> vertices;
  for (const auto& [a, b, c] : mesh.triangles) {
    vertices.insert({a, b, c});
    parent[root(a)] = root(b);
    parent[root(b)] = root(c);
  }
  std::set<std::uint32_t> roots;
  for (const std::uint32_t vertex : vertices) roots.insert(root(vertex));
  const auto v = static_cast<int>(vertices.size());
  const auto f = static_cast<int>(mesh.triangles.size());
  const auto components = static_cast<int>(roots.size());
  return {components, components - (v - f / 2) / 2};  // E = 3 F / 2
}

TEST(Woven, SlicesHaveTheTopologyOfTheSolid) {
  for (const fixtures::Field& field : fixtures::allFields()) {
    SCOPED_TRACE(field.name);
    const auto frames =
        static_cast<std::size_t>(field.slope == 0 ? field.timeEnd - field.timeBegin + 1 : 25);
    Woven woven = wovenFrom(field, 1, frames, true);
    EXPECT_TRUE(*woven.report.vertexLinksOk);
    for (const fixtures::Topology& expected : field.topology) {
      SCOPED_TRACE(expected.time);
      const auto slice = sliceAtTime(woven.mesh, expected.time);
      ASSERT_TRUE(slice) << slice.error().text();
      EXPECT_TRUE(isClosed(slice->mesh));
      const SurfaceTopology found = topologyOf(slice->mesh);
      EXPECT_EQ(found.components, expected.components);
      EXPECT_EQ(found.genus, expected.genus);
    }
  }
}

/// Halves voxels and frame time twice; prints the observed order and returns the last.
double observedOrder(const char* what, const std::vector<double>& errors) {
  std::cout << what << ": errors";
  for (const double error : errors) std::cout << " " << error;
  std::cout << ", observed order";
  double order = 0;
  for (std::size_t i = 1; i < errors.size(); ++i) {
    order = std::log2(errors[i - 1] / errors[i]);
    std::cout << " " << order;
  }
  std::cout << "\n";
  // The mean is over both halvings, which averages the effect of the lattice's position.
  return std::log2(errors.front() / errors.back()) / static_cast<double>(errors.size() - 1);
}

void convergence(const fixtures::Field& field, double coarsest, double leastOrder) {
  SCOPED_TRACE(field.name);
  std::vector<double> hypervolume;
  std::vector<double> volume;
  for (const int refinement : {1, 2, 4}) {
    Woven woven = wovenFrom(field, coarsest / refinement, 8 * refinement + 1);
    hypervolume.push_back(std::abs(woven.report.hypervolume - *field.hypervolume) /
                          *field.hypervolume);
    double sum = 0;
    const auto times = model::evenTimes({field.timeBegin, field.timeEnd}, 14);
    for (const double time : times) {
      const double expected = field.volume(time);
      sum += std::abs(signedVolume(sliceAtTime(woven.mesh, time)->mesh) - expected) / expected;
    }
    volume.push_back(sum / static_cast<double>(times.size()));
  }
  EXPECT_GT(observedOrder((field.name + ", hypervolume").c_str(), hypervolume), leastOrder);
  EXPECT_GT(observedOrder((field.name + ", slice volume").c_str(), volume), leastOrder);
}

TEST(Woven, MovingSphereConvergesWithOrderTwo) {
  convergence(fixtures::translatingSphere(8, {4, 2, 3}), 2, 1.8);
}

TEST(Woven, RotatingCubeConverges) { convergence(fixtures::rotatingCube(12), 2, 1.5); }

}  // namespace
}  // namespace t4d::slice
