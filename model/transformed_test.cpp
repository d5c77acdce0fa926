#include <array>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "fixtures/pieces.h"
#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::model {
namespace {

/// A ball that turns while it moves.
Mesh turningBall(const mesh4d::SweepOptions& options = {}) {
  const std::vector<ScrewRun> runs = {
      {2, {Point3(1, 2, 3), Eigen::Vector3d(0, 1, 1), 140, Eigen::Vector3d(3, 0, 1)}, 1}};
  const auto motion = chainScrews(0, runs);
  Mesh mesh;
  EXPECT_TRUE(motion && mesh4d::sweep(fixtures::icosphere(2, 1), *motion, options, mesh));
  return mesh;
}

/// Hypervolume is multiplied by |det A| and the scale of time, whether A mirrors or not; layers
/// stay posed, and seams exact.
TEST(Transformed, KeepsMeshesOutwardAndPosed) {
  const Mesh given = turningBall();
  const double hypervolume = measure::checkMesh(given)->hypervolume;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 10; ++trial) {
    SCOPED_TRACE(trial);
    Transform by;
    for (double& entry : by.space.reshaped()) entry = normal(random);
    if (trial == 0) by.space.leftCols<3>().setIdentity();
    by.timeScale = 1 + 0.3 * trial;
    by.timeShift = normal(random);
    Mesh mesh;
    Transformed sink(mesh, by);
    for (const Slab& slab : given.slabs()) ASSERT_TRUE(sink.put(slab));
    const auto report = measure::checkMesh(mesh);
    ASSERT_TRUE(report && report->valid()) << report->issues.issues.front().message;
    const double expected =
        hypervolume * by.timeScale * std::abs(by.space.leftCols<3>().determinant());
    EXPECT_NEAR(report->hypervolume, expected, 1e-11 * expected);
    std::size_t posedLayers = 0;
    for (std::size_t i = 0; i < mesh.slabCount(); ++i) {
      const Slab& slab = mesh.slabs()[i];
      if (slab.upperPose) posedLayers += slab.upperPose->gives(slab.upperLayer()) ? 1 : 0;
      for (std::size_t v = 0; v < slab.vertices.size(); ++v) {
        EXPECT_TRUE(slab.vertices[v].isApprox(by(given.slabs()[i].vertices[v]), 1e-12));
      }
    }
    EXPECT_EQ(posedLayers, mesh.slabCount() - 1);
  }
}

/// Values of cells are mapped each for itself, as those of vertices; means are means of the latter
/// only.
TEST(Transformed, VectorsOfCellsTurnInEachCell) {
  const Mesh given = turningBall();
  Slab slab = given.slabs()[1];
  auto connectivity = std::make_shared<Connectivity>(*slab.connectivity);
  std::vector<double> rows;
  for (std::size_t i = 0; i < 3 * connectivity->cells.size(); ++i) {
    rows.push_back(static_cast<double>(i % 7) - 2);
  }
  Attribute push = makeAttribute("push", Domain::Cell, rows);
  push.components = 3;
  connectivity->cellAttributes.push_back(push);
  slab.connectivity = connectivity;
  Transform by;
  by.space.leftCols<3>() << 0, -1, 0, 1, 0, 0, 0, 0, 2;
  Mesh mesh;
  Transformed sink(mesh, by, {{"push", {"vector", ""}}});
  ASSERT_TRUE(sink.put(slab));
  const Attribute& mapped = mesh.slabs()[0].connectivity->cellAttributes.back();
  ASSERT_EQ(mapped.name, "push");
  for (std::size_t i = 0; i < connectivity->cells.size(); ++i) {
    std::array<double, 3> row{};
    std::memcpy(row.data(), mapped.values.data() + i * sizeof row, sizeof row);
    const Point3 was(rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]);
    ASSERT_EQ(Point3(row[0], row[1], row[2]), by.space.leftCols<3>() * was) << i;
  }
}

/// A slab put as a stream leaves nothing of the layer before it, and obeys the same rule of times.
TEST(Transformed, StreamedSlabsAreMappedAsOthers) {
  const Mesh given = turningBall({.prism = mesh4d::PrismSplit::Three});  // no means
  Transform by;
  by.space.leftCols<3>() *= 3;
  by.timeScale = 2;
  Mesh mesh;
  Transformed sink(mesh, by);
  for (std::size_t i = 0; i < given.slabCount(); ++i) {
    const Slab& slab = given.slabs()[i];
    ASSERT_TRUE(i % 3 == 1 ? sink.putStreamed(fixtures::Pieces(slab)) : sink.put(slab));
  }
  const auto report = measure::checkMesh(mesh);
  ASSERT_TRUE(report && report->valid()) << report->issues.issues.front().message;
  Transform coarse;
  coarse.timeShift = 1e30;
  Transformed lost(mesh, coarse);
  EXPECT_FALSE(lost.put(given.slabs()[1]));
  EXPECT_FALSE(lost.putStreamed(fixtures::Pieces(given.slabs()[1])));
}

}  // namespace
}  // namespace t4d::model
