#include <algorithm>
#include <filesystem>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "measure/slab_measure.h"
#include "model/facets.h"
#include "platform/test_folder.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "tools/t4d/validation.h"

namespace t4d::measure {
namespace {

using testing::Contains;
using testing::Field;

/// The boundary of the 4-simplex at the origin and the four unit points: one slab with empty
/// layers.
model::Slab pentachoron() {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  for (std::uint32_t opposite = 0; opposite < 5; ++opposite) {
    model::Cell cell;
    std::uint32_t corner = 0;
    for (std::uint32_t v = 0; v < 5; ++v) {
      if (v != opposite) cell[corner++] = v;
    }
    // det[v1-v0, ..., v4-v0] > 0: the facet opposite vertex i has the sign (-1)^i, outward
    // reversed.
    if (opposite % 2 != 0) std::swap(cell[0], cell[1]);
    connectivity->cells.push_back(cell);
  }
  model::Slab slab;
  slab.timeEnd = 1;
  slab.connectivity = connectivity;
  slab.vertices = {model::Point4::Zero(), model::Point4::UnitX(), model::Point4::UnitY(),
                   model::Point4::UnitZ(), model::Point4::UnitW()};
  return slab;
}

/// A tetrahedron at rest from t = 0 to `steps`, closed at both ends: caps of one cell, and
/// three-cell prisms. Written out here so that this test does not depend on a builder.
std::vector<model::Slab> restingTetrahedron(int steps) {
  const std::array<Eigen::Vector3d, 4> corners = {
      Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0),
      Eigen::Vector3d(0, 0, 1)};
  const auto layer = [&](double t, std::vector<model::Point4>& into) {
    for (const auto& corner : corners) into.emplace_back(corner[0], corner[1], corner[2], t);
  };
  std::vector<model::Slab> slabs;
  auto start = std::make_shared<model::Connectivity>();
  start->vertexCount = start->upperCount = 4;
  start->cells = {{0, 1, 2, 3}};
  auto end = std::make_shared<model::Connectivity>();
  end->vertexCount = end->lowerCount = 4;
  end->cells = {{1, 0, 2, 3}};
  auto side = std::make_shared<model::Connectivity>();
  side->vertexCount = 8;
  side->lowerCount = side->upperCount = 4;
  for (std::array<std::uint32_t, 3> t :
       {std::array<std::uint32_t, 3>{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    const bool even = model::orientedFacet(t[0], t[1], t[2]).even;
    std::sort(t.begin(), t.end());
    for (model::Cell cell :
         {model::Cell{t[0], t[1], t[2], 4 + t[2]}, model::Cell{t[0], t[1], 4 + t[2], 4 + t[1]},
          model::Cell{t[0], 4 + t[1], 4 + t[2], 4 + t[0]}}) {
      if (!even) std::swap(cell[0], cell[1]);
      side->cells.push_back(cell);
    }
  }
  model::Slab cap;
  cap.connectivity = start;
  layer(0, cap.vertices);
  slabs.push_back(cap);
  for (int step = 0; step < steps; ++step) {
    model::Slab slab;
    slab.timeBegin = step;
    slab.timeEnd = step + 1;
    slab.connectivity = side;
    layer(step, slab.vertices);
    layer(step + 1, slab.vertices);
    slabs.push_back(slab);
  }
  model::Slab last;
  last.timeBegin = last.timeEnd = steps;
  last.connectivity = end;
  layer(steps, last.vertices);
  slabs.push_back(last);
  return slabs;
}

MeshReport check(const std::vector<model::Slab>& slabs, bool links = true) {
  MeshChecker checker({.vertexLinks = links});
  for (const model::Slab& slab : slabs) {
    const auto put = checker.put(slab);
    EXPECT_TRUE(put) << put.error().text();
  }
  return checker.finish();
}

std::vector<std::string> codes(const MeshReport& report) {
  std::vector<std::string> all;
  for (const Issue& issue : report.issues.issues) all.push_back(issue.code);
  return all;
}

/// The slab with a connectivity of its own, to be modified.
model::Connectivity& own(model::Slab& slab) {
  auto copy = std::make_shared<model::Connectivity>(*slab.connectivity);
  model::Connectivity& editable = *copy;
  slab.connectivity = std::move(copy);
  return editable;
}

TEST(MeshCheck, PentachoronEnclosesOneTwentyFourth) {
  const MeshReport report = check({pentachoron()});
  EXPECT_TRUE(report.valid()) << report.issues.issues.front().message;
  EXPECT_TRUE(report.closed && report.oriented && *report.vertexLinksOk);
  EXPECT_NEAR(report.hypervolume, 1.0 / 24, 1e-15);
  // Four facets are right tetrahedra of volume 1/6, the fifth is regular with side sqrt(2).
  EXPECT_NEAR(report.boundaryVolume, 4.0 / 6 + 2.0 / 6, 1e-15);
  EXPECT_EQ(report.components, 1U);
  EXPECT_EQ(report.degenerateCells, 0U);
}

TEST(MeshCheck, RestingTetrahedronEnclosesVolumeTimesDuration) {
  const MeshReport report = check(restingTetrahedron(5));
  EXPECT_TRUE(report.valid()) << report.issues.issues.front().message;
  EXPECT_NEAR(report.hypervolume, 5.0 / 6, 1e-14);
  EXPECT_EQ(report.vertices, 24U);
  EXPECT_EQ(report.tetrahedra, 2U + 5U * 12U);
  EXPECT_EQ(report.components, 1U);
  EXPECT_TRUE(*report.vertexLinksOk);
}

TEST(MeshCheck, HypervolumeDoesNotDependOnWhereTheMeshIs) {
  auto slabs = restingTetrahedron(3);
  for (model::Slab& slab : slabs) {
    for (model::Point4& vertex : slab.vertices) vertex.head<3>().array() += 4096;
  }
  EXPECT_NEAR(check(slabs).hypervolume, 0.5, 1e-12);
}

TEST(MeshCheck, TwoMeshesInOneAreTwoComponents) {
  model::Slab two = pentachoron();
  model::Connectivity& connectivity = own(two);
  for (std::size_t i = 0; i < 5; ++i) {
    model::Cell cell = connectivity.cells[i];
    for (auto& vertex : cell) vertex += 5;
    connectivity.cells.push_back(cell);
    two.vertices.push_back(two.vertices[i] + model::Point4(9, 9, 9, 0));
  }
  connectivity.vertexCount = 10;
  EXPECT_EQ(check({two}).components, 2U);
}

TEST(MeshCheck, AnyCellTakenAwayOpensTheMesh) {
  const auto whole = restingTetrahedron(3);
  for (std::size_t s = 0; s < whole.size(); ++s) {
    for (std::size_t c = 0; c < whole[s].connectivity->cells.size(); ++c) {
      auto slabs = whole;
      model::Connectivity& connectivity = own(slabs[s]);
      connectivity.cells.erase(connectivity.cells.begin() + static_cast<std::ptrdiff_t>(c));
      const MeshReport report = check(slabs);
      EXPECT_FALSE(report.closed);
      EXPECT_FALSE(report.valid());
      EXPECT_THAT(codes(report), Contains("facet-not-shared-by-two"));
    }
  }
}

TEST(MeshCheck, AnyCellTurnedRoundBreaksTheOrientation) {
  const auto whole = restingTetrahedron(2);
  for (std::size_t s = 0; s < whole.size(); ++s) {
    for (std::size_t c = 0; c < whole[s].connectivity->cells.size(); ++c) {
      auto slabs = whole;
      model::Cell& cell = own(slabs[s]).cells[c];
      std::swap(cell[0], cell[1]);
      const MeshReport report = check(slabs);
      EXPECT_TRUE(report.closed);
      EXPECT_FALSE(report.oriented);
      EXPECT_THAT(codes(report), Contains("facet-orientation"));
    }
  }
}

TEST(MeshCheck, AnyCellTwiceIsFound) {
  const auto whole = restingTetrahedron(2);
  for (std::size_t s = 0; s < whole.size(); ++s) {
    auto slabs = whole;
    model::Connectivity& connectivity = own(slabs[s]);
    connectivity.cells.push_back(connectivity.cells.back());
    EXPECT_FALSE(check(slabs).closed);
  }
}

TEST(MeshCheck, InsideOutMeshIsAnError) {
  auto slabs = restingTetrahedron(2);
  for (model::Slab& slab : slabs) {
    for (model::Cell& cell : own(slab).cells) std::swap(cell[0], cell[1]);
  }
  const MeshReport report = check(slabs);
  EXPECT_TRUE(report.closed && report.oriented);
  EXPECT_LT(report.hypervolume, 0);
  EXPECT_THAT(codes(report), Contains("inside-out"));
}

TEST(MeshCheck, SeamThatDiffersInOneBitIsFound) {
  auto slabs = restingTetrahedron(2);
  slabs[2].vertices[1][0] = std::nextafter(1.0, 2.0);
  const MeshReport report = check(slabs);
  ASSERT_THAT(codes(report), Contains("seam-differs"));
  EXPECT_EQ(report.issues.issues.front().slab, 2U);
}

TEST(MeshCheck, AttributesThatDifferAtASeamAreFound) {
  auto slabs = restingTetrahedron(2);
  for (model::Slab& slab : slabs) {
    const std::vector<std::uint8_t> same(slab.vertices.size(), 7);
    slab.attributes = {model::makeAttribute("a", model::Domain::Vertex, same)};
  }
  EXPECT_TRUE(check(slabs).valid());
  slabs[2].attributes[0].values[1] = std::byte{8};
  const MeshReport report = check(slabs);
  ASSERT_THAT(codes(report), Contains("seam-differs"));
  EXPECT_EQ(report.issues.issues.front().slab, 2U);
}

TEST(MeshCheck, BothZerosAreTheSamePlace) {
  auto slabs = restingTetrahedron(2);
  double& zero = slabs[2].vertices[0][0];
  ASSERT_EQ(zero, 0);
  zero = -0.0;
  EXPECT_TRUE(check(slabs).valid());
}

TEST(MeshCheck, MissingSlabIsFound) {
  auto slabs = restingTetrahedron(4);
  slabs.erase(slabs.begin() + 2);
  EXPECT_THAT(codes(check(slabs)), Contains("slab-times"));
}

TEST(MeshCheck, MissingEndCapOpensTheMesh) {
  auto slabs = restingTetrahedron(2);
  slabs.pop_back();
  const MeshReport report = check(slabs);
  EXPECT_FALSE(report.closed);
  EXPECT_EQ(report.issues.issues.front().slab, slabs.size() - 1);
}

TEST(MeshCheck, CollapsedCellIsAWarning) {
  model::Slab slab = pentachoron();
  slab.vertices[4] = slab.vertices[3];
  slab.timeEnd = 0;
  const MeshReport report = check({slab});
  EXPECT_GT(report.degenerateCells, 0U);
  EXPECT_THAT(codes(report), Contains("degenerate-cell"));
}

/// Two pentachora that share vertex 0.
model::Slab pinched() {
  model::Slab two = pentachoron();
  model::Connectivity& connectivity = own(two);
  for (std::size_t i = 0; i < 5; ++i) {
    model::Cell cell = connectivity.cells[i];
    for (auto& vertex : cell) vertex += vertex == 0 ? 0 : 4;
    connectivity.cells.push_back(cell);
  }
  for (int i = 1; i < 5; ++i) {
    const model::Point4 mirrored = two.vertices[i].cwiseProduct(model::Point4(-1, -1, 1, 1)) / 2;
    two.vertices.push_back(mirrored);
  }
  connectivity.vertexCount = 9;
  return two;
}

/// The cone over a sphere-like surface is fine; over two surfaces its apex is pinched.
TEST(MeshCheck, PinchedVertexFailsTheDeepCheckOnly) {
  const model::Slab two = pinched();
  EXPECT_TRUE(check({two}, false).valid());
  const MeshReport deep = check({two}, true);
  EXPECT_FALSE(*deep.vertexLinksOk);
  EXPECT_THAT(codes(deep), Contains("vertex-link"));
}

TEST(ValidateT4dFile, LinksOfAllBodiesHaveToBeSound) {
  for (const bool first : {false, true}) {
    formats::Metadata metadata;
    metadata.bodies = {{"one"}, {"other"}};
    const platform::TestFolder folder;
    const auto path = folder / "links.t4d";
    auto writer = formats::T4dWriter::create(path, metadata, {});
    ASSERT_TRUE(writer);
    for (const bool bad : {first, !first}) {
      const model::Slab slab = bad ? pinched() : pentachoron();
      ASSERT_TRUE(writer->body(bad == first ? 0 : 1).put(slab));
    }
    ASSERT_TRUE(writer->finish());
    const auto found = tools::validate(path, {.vertexLinks = true});
    std::filesystem::remove(path);
    ASSERT_TRUE(found && found->mesh);
    EXPECT_FALSE(*found->mesh->vertexLinksOk);
  }
}

TEST(HypervolumeSign, CountsTheLastCellAfterAPieceOfOthers) {
  // Cells are added up by 16,384. The last one outweighs all others, and faces the other way.
  std::vector<model::Point4> points = {
      {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  for (std::size_t i = 1; i < 5; ++i) points.push_back(100 * points[i]);
  std::vector<model::Cell> cells(16'384, model::Cell{1, 2, 3, 4});
  const int sign = hypervolumeSign(points, cells);
  EXPECT_NE(sign, 0);
  cells.push_back({6, 5, 7, 8});
  EXPECT_EQ(hypervolumeSign(points, cells), -sign);
}

TEST(MeshCheck, FindingsAreCountedAllAndKeptInPart) {
  IssueList list;
  for (int i = 0; i < 1000; ++i) list.add({"code", Severity::Error, "message", {}, {}});
  EXPECT_EQ(list.errors, 1000U);
  EXPECT_EQ(list.issues.size(), IssueList::kKeptOfEachCode);
}

}  // namespace
}  // namespace t4d::measure
