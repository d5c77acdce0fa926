#include <cmath>
#include <cstring>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fixtures/polytopes.h"
#include "fixtures/star_polytopes.h"
#include "formats/mesh4d/off4d_reader.h"
#include "measure/slab_measure.h"
#include "t4d/edit.h"
#include "t4d/file.h"

namespace t4d::edit {
namespace {

using formats::Mesh4d;

Mesh4d bodyOf(const fixtures::Polytope& polytope) {
  return {polytope.name, polytope.vertices, fixtures::tetrahedra(polytope)};
}

double hypervolume(const Mesh4d& mesh) {
  double sum = 0;
  for (const model::Cell& cell : mesh.cells) {
    Eigen::Matrix4d matrix;
    for (int i = 0; i < 4; ++i) matrix.row(i) = mesh.vertices[cell[i]];
    sum += matrix.determinant() / 24;
  }
  return sum;
}

TEST(MendMesh4d, ChangesNothingInAMeshThatIsSound) {
  Mesh4d mesh = bodyOf(fixtures::cell600());
  const auto cells = mesh.cells;
  const auto report = mendMesh4d(mesh);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(report->closed && report->oriented && report->changes.empty());
  EXPECT_EQ(mesh.cells, cells);
}

TEST(MendMesh4d, KeepsAMeshThatFacesOutwardWhateverItsCoordinates) {
  const Mesh4d simplex = bodyOf(fixtures::cell16());
  for (const double far : {1e20, 1e40, 1e69}) {
    for (std::size_t moved = 0; moved < simplex.vertices.size(); ++moved) {
      for (int axis = 0; axis < 4; ++axis) {
        Mesh4d mesh = simplex;
        mesh.vertices[moved][axis] += far;
        const auto found = measure::hypervolumeSign(mesh.vertices, mesh.cells);
        const auto cells = mesh.cells;
        const auto report = mendMesh4d(mesh);
        if (found == 0) continue;
        ASSERT_TRUE(report) << report.error().text();
        EXPECT_EQ(mesh.cells == cells, found > 0) << far << " " << moved << " " << axis;
        EXPECT_EQ(measure::hypervolumeSign(mesh.vertices, mesh.cells), 1);
      }
    }
  }
}

TEST(MendMesh4d, StarPolytopesEncloseTheSumOverTheirFlags) {
  for (const fixtures::Polytope& polytope : fixtures::starPolytopes()) {
    auto loaded = formats::readStellaOff({"star.off", fixtures::offText(polytope)});
    ASSERT_TRUE(loaded) << loaded.error().text();
    ASSERT_EQ(loaded->bodies.size(), 1U);
    const auto report = mendMesh4d(loaded->bodies[0]);
    ASSERT_TRUE(report) << polytope.name << " " << report.error().text();
    EXPECT_TRUE(report->closed && report->oriented) << polytope.name;
    EXPECT_NEAR(hypervolume(loaded->bodies[0]) / polytope.hypervolume, 1, 1e-12) << polytope.name;
    // Faces of two have no triangle in common when they are pulled; the others get centres.
    const std::size_t corners = polytope.vertices.size();
    const bool pulled = polytope.name == "{3,3,5/2}" || polytope.name == "{5/2,3,3}";
    EXPECT_EQ(loaded->bodies[0].vertices.size(),
              pulled ? corners : corners + polytope.faces.size() + polytope.cells.size());
  }
}

TEST(MendMesh4d, MendsAtAnySize) {
  for (const int exponent : {-465, -100, 0, 100, 465}) {
    Mesh4d mesh = bodyOf(fixtures::cell600());
    const auto cells = mesh.cells;
    for (model::Point4& vertex : mesh.vertices) vertex *= std::ldexp(1.0, exponent);
    for (std::size_t i = 0; i < mesh.cells.size(); i += 3) {
      std::swap(mesh.cells[i][2], mesh.cells[i][3]);
    }
    const auto report = mendMesh4d(mesh);
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_EQ(mesh.cells, cells) << exponent;
  }
}

TEST(MendMesh4d, AttributesFollowWhatIsMerged) {
  // Every tetrahedron with corners of its own.
  const Mesh4d given = bodyOf(fixtures::cell16());
  Mesh4d mesh;
  std::vector<std::int32_t> ofVertices;
  std::vector<std::int32_t> ofCells;
  for (const model::Cell& cell : given.cells) {
    model::Cell own{};
    for (int i = 0; i < 4; ++i) {
      own[i] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(given.vertices[cell[i]]);
      ofVertices.push_back(static_cast<std::int32_t>(cell[i]));
    }
    mesh.cells.push_back(own);
    ofCells.push_back(static_cast<std::int32_t>(ofCells.size()));
  }
  mesh.attributes = {model::makeAttribute("v", model::Domain::Vertex, ofVertices),
                     model::makeAttribute("c", model::Domain::Cell, ofCells)};
  ASSERT_TRUE(mendMesh4d(mesh));
  ASSERT_EQ(mesh.vertices.size(), given.vertices.size());
  ASSERT_EQ(mesh.attributes[0].rows(), mesh.vertices.size());
  ASSERT_EQ(mesh.attributes[1].rows(), mesh.cells.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    std::int32_t vertex = 0;
    std::memcpy(&vertex, mesh.attributes[0].row(i), sizeof vertex);
    EXPECT_EQ(mesh.vertices[i], given.vertices[static_cast<std::size_t>(vertex)]);
  }
}

TEST(MendMesh4d, OrientsEachPartOutward) {
  const fixtures::Polytope polytope = fixtures::cell600();
  Mesh4d mesh = bodyOf(polytope);
  // A second part far away; every third cell of both the wrong way round.
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto cells = mesh.cells;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    mesh.vertices.push_back(mesh.vertices[i] + model::Point4(10, 0, 0, 0));
  }
  for (model::Cell cell : cells) {
    for (std::uint32_t& corner : cell) corner += vertices;
    mesh.cells.push_back(cell);
  }
  for (std::size_t i = 0; i < mesh.cells.size(); i += 3) {
    std::swap(mesh.cells[i][0], mesh.cells[i][1]);
  }
  const auto report = mendMesh4d(mesh);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(report->closed && report->oriented);
  EXPECT_THAT(report->changes,
              testing::ElementsAre("turned 400 tetrahedra, so that neighbours agree"));
  EXPECT_NEAR(hypervolume(mesh), 2 * polytope.hypervolume, 1e-9);
}

TEST(MendMesh4d, RefusesASolidThatEqualVerticesMakeFlat) {
  // The boundary of a 4-simplex, with two of its vertices at one point.
  const model::Point4 origin = model::Point4::Zero();
  const std::vector<model::Point4> points = {origin, origin, model::Point4::Unit(1),
                                             model::Point4::Unit(2), model::Point4::Unit(3)};
  const std::vector<model::Cell> cells = {
      {1, 2, 3, 4}, {0, 2, 4, 3}, {0, 1, 3, 4}, {0, 1, 4, 2}, {0, 1, 2, 3}};
  Mesh4d flat{"", points, cells};
  const auto refused = mendMesh4d(flat);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "encloses no hypervolume: 3 of its 5 tetrahedra are flat, and 1 of its 5 vertices lie "
            "exactly on others");
  Mesh4d allowed{"", points, cells};
  EXPECT_TRUE(mendMesh4d(allowed, {.allowOpen = true}));
}

TEST(MendMesh4d, TurnsAMeshThatIsInsideOut) {
  const fixtures::Polytope polytope = fixtures::cell16();
  Mesh4d mesh = bodyOf(polytope);
  for (model::Cell& cell : mesh.cells) std::swap(cell[0], cell[1]);
  const auto report = mendMesh4d(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->changes.size(), 1U);
  EXPECT_NEAR(hypervolume(mesh), polytope.hypervolume, 1e-12);
}

TEST(MendMesh4d, MergesDoubledVerticesOnlyIfTheMeshIsOpen) {
  const fixtures::Polytope polytope = fixtures::cell16();
  Mesh4d soup;
  for (const model::Cell& cell : fixtures::tetrahedra(polytope)) {
    model::Cell own{};
    for (int i = 0; i < 4; ++i) {
      own[i] = static_cast<std::uint32_t>(soup.vertices.size());
      soup.vertices.push_back(polytope.vertices[cell[i]]);
    }
    soup.cells.push_back(own);
  }
  Mesh4d mesh = soup;
  const auto report = mendMesh4d(mesh);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_THAT(report->changes, testing::ElementsAre("merged 56 vertices that equal others"));
  EXPECT_EQ(mesh.vertices.size(), 8U);
  EXPECT_NEAR(hypervolume(mesh), polytope.hypervolume, 1e-12);

  // Not quite equal: within the tolerance, no less.
  for (std::size_t i = 0; i < soup.vertices.size(); ++i) soup.vertices[i][i % 4] += 1e-6 * (i % 3);
  mesh = soup;
  EXPECT_FALSE(mendMesh4d(mesh));
  mesh = soup;
  EXPECT_FALSE(mendMesh4d(mesh, {.weld = 1e-7}));
  mesh = soup;
  ASSERT_TRUE(mendMesh4d(mesh, {.weld = 3e-6}));
  EXPECT_EQ(mesh.vertices.size(), 8U);

  // Two solids that touch in a vertex are left alone.
  Mesh4d two = bodyOf(polytope);
  for (const model::Cell& cell : fixtures::tetrahedra(polytope)) {
    two.cells.push_back({cell[0] + 8, cell[1] + 8, cell[2] + 8, cell[3] + 8});
  }
  for (int i = 0; i < 8; ++i) two.vertices.push_back(two.vertices[i] + model::Point4(2, 0, 0, 0));
  ASSERT_TRUE(mendMesh4d(two));
  EXPECT_EQ(two.vertices.size(), 16U);
}

TEST(MendMesh4d, RefusesAnOpenMeshUnlessAllowed) {
  Mesh4d mesh = bodyOf(fixtures::cell16());
  mesh.cells.pop_back();
  Mesh4d same = mesh;
  const auto refused = mendMesh4d(mesh);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().remedy, Remedy::OpenMesh);
  EXPECT_THAT(refused.error().message,
              testing::StartsWith("is not closed: 4 of its triangles do not have two tetrahedra"));
  const auto allowed = mendMesh4d(same, {.allowOpen = true});
  ASSERT_TRUE(allowed);
  EXPECT_FALSE(allowed->closed);
  EXPECT_TRUE(allowed->oriented);
}

TEST(MendMesh4d, RefusesAMeshWithOneSide) {
  // A chain of tetrahedra, each glued to the next, whose end is glued to its beginning the wrong
  // way round.
  Mesh4d ring;
  for (int i = 0; i < 8; ++i) {
    const double angle = 0.7 * i;
    ring.vertices.emplace_back(std::cos(angle), std::sin(angle), 0.3 * i, 0.1 * i * i);
  }
  constexpr std::uint32_t kChain[] = {0, 1, 2, 3, 4, 5, 6, 7, 1, 0, 2};
  for (int i = 0; i < 8; ++i) {
    ring.cells.push_back({kChain[i], kChain[i + 1], kChain[i + 2], kChain[i + 3]});
  }
  Mesh4d same = ring;
  EXPECT_FALSE(mendMesh4d(same));
  const auto report = mendMesh4d(ring, {.allowOpen = true});
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->oriented);
}

}  // namespace
}  // namespace t4d::edit
