#include "tools/t4d/diff.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/mesh_digest.h"
#include "platform/test_folder.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;

class Diffs : public testing::Test {
 protected:
  static model::Mesh swept(const model::TriangleMesh& solid, std::size_t steps) {
    model::Mesh mesh;
    const auto motion =
        formats::parseMotion(R"({"segments":[{"duration":2,"translation":[0,0,4]}]})", "motion");
    EXPECT_TRUE(motion);
    EXPECT_TRUE(mesh4d::sweep(solid, *motion,
                              {mesh4d::StepsPerSegment{steps}, mesh4d::CapMethod::Cone}, mesh));
    return mesh;
  }

  fs::path file(const std::string& name, const model::Source& mesh,
                const formats::T4dWriteOptions& how = {}, const std::string& unit = "") const {
    formats::Metadata metadata;
    metadata.lengthUnit = unit;
    metadata.bodies = {{"body"}};
    auto writer = formats::T4dWriter::create(folder_ / name, metadata, how);
    EXPECT_TRUE(writer);
    EXPECT_TRUE(model::pump(mesh, writer->body(0)));
    EXPECT_TRUE(writer->finish());
    return folder_ / name;
  }

  static SameLevel levelOf(const fs::path& a, const fs::path& b, const DiffOptions& options = {}) {
    const auto found = diff(a, b, options);
    EXPECT_TRUE(found) << found.error().text();
    return found->level;
  }

 private:
  platform::TestFolder folder_;
};

TEST_F(Diffs, LevelsAreToldApart) {
  const model::Mesh mesh = swept(fixtures::torus(4, 1.5, 12, 8), 6);
  const fs::path first = file("first.t4d", mesh);
  EXPECT_EQ(levelOf(first, file("same.t4d", mesh)), SameLevel::Bytes);
  EXPECT_EQ(levelOf(first, file("level.t4d", mesh, {.compression = 9})), SameLevel::Mesh);
  EXPECT_EQ(levelOf(first, file("unit.t4d", mesh, {}, "mm")), SameLevel::Mesh);
  EXPECT_EQ(levelOf(file("mm.t4d", mesh, {}, "mm"), file("m.t4d", mesh, {}, "m")),
            SameLevel::Different);
  // A straight motion is the same solid in any number of steps.
  const fs::path finer = file("finer.t4d", swept(fixtures::torus(4, 1.5, 12, 8), 7));
  EXPECT_EQ(levelOf(first, finer, {.times = 2}), SameLevel::Solid);
  model::Transform shift;
  shift.space(0, 3) = 0.01;
  model::Mesh moved;
  model::Transformed sink(moved, shift);
  ASSERT_TRUE(model::pump(mesh, sink));
  const fs::path away = file("away.t4d", moved);
  EXPECT_EQ(levelOf(first, away, {.tolerance = 0.02}), SameLevel::Solid);
  EXPECT_EQ(levelOf(first, away, {.tolerance = 0.005}), SameLevel::Different);
}

TEST(MeshDigest, DependsOnCellsAloneAndOnTheWayRoundTheyAre) {
  std::mt19937 random(21);
  const auto digestOf = [](const model::Slab& slab) {
    measure::MeshDigester digester;
    EXPECT_TRUE(digester.put(slab));
    return digester.digest();
  };
  const auto slabOf = [](std::vector<model::Point4> vertices, std::vector<model::Cell> cells) {
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = static_cast<std::uint32_t>(vertices.size());
    connectivity->cells = std::move(cells);
    return model::Slab{0, 1, std::move(vertices), connectivity, {}};
  };
  std::uniform_real_distribution<double> coordinate(-1, 1);
  std::vector<model::Point4> vertices(20);
  for (auto& vertex : vertices) {
    for (double& x : vertex) x = coordinate(random);
  }
  vertices[3].x() = 0;
  std::vector<model::Cell> cells(50);
  std::vector<std::uint32_t> some(vertices.size());
  std::iota(some.begin(), some.end(), 0U);
  for (model::Cell& cell : cells) {
    std::ranges::shuffle(some, random);
    std::copy_n(some.begin(), 4, cell.begin());
  }
  const measure::MeshDigest digest = digestOf(slabOf(vertices, cells));
  for (int round = 0; round < 50; ++round) {
    // Other numbers of the vertices, another order of cells, even permutations of their corners.
    std::ranges::shuffle(some, random);
    std::vector<model::Point4> renumbered(vertices.size());
    for (std::size_t i = 0; i < some.size(); ++i) renumbered[some[i]] = vertices[i];
    renumbered[some[3]].x() = -0.0;
    auto shuffled = cells;
    for (model::Cell& cell : shuffled) {
      for (std::uint32_t& corner : cell) corner = some[corner];
      const unsigned i = random() % 4;
      std::swap(cell[i], cell[(i + 1) % 4]);
      std::swap(cell[(i + 2) % 4], cell[(i + 3) % 4]);
    }
    std::ranges::shuffle(shuffled, random);
    EXPECT_EQ(digestOf(slabOf(renumbered, shuffled)), digest);
  }
  for (int round = 0; round < 50; ++round) {
    auto other = cells;
    model::Cell& cell = other[random() % other.size()];
    std::swap(cell[0], cell[1 + random() % 3]);
    EXPECT_NE(digestOf(slabOf(vertices, other)), digest);
    auto moved = vertices;
    double& x = moved[cells[random() % cells.size()][0]][random() % 4];
    x = std::nextafter(x, 2);
    EXPECT_NE(digestOf(slabOf(moved, cells)), digest);
  }
}

}  // namespace
}  // namespace t4d::tools
