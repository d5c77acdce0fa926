#include "t4d/slice.h"

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "model/units.h"
#include "platform/test_folder.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"

namespace t4d::slice {
namespace {

TEST(Hyperplane, BasisOfAnAxisIsTheOtherAxesInOrder) {
  for (int axis = 0; axis < 4; ++axis) {
    const HyperplaneBasis basis = basisOf(Hyperplane::across(axis, 2));
    int row = 0;
    for (int other = 0; other < 4; ++other) {
      if (other == axis) continue;
      EXPECT_EQ(basis.axes.row(row++).transpose(), Eigen::Vector4d(Eigen::Vector4d::Unit(other)));
    }
    EXPECT_EQ(basis.rightHanded, axis % 2 == 1);
  }
}

TEST(Hyperplane, BasisIsOrthonormalAndLiesInTheHyperplane) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 500; ++i) {
    Hyperplane hyperplane{{number(random), number(random), number(random), number(random)}, 0};
    if (i % 5 == 0) hyperplane.normal[i % 4] *= 1e-12;
    const HyperplaneBasis basis = basisOf(hyperplane);
    EXPECT_LT((basis.axes * basis.axes.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT((basis.axes * hyperplane.normal.normalized()).norm(), 1e-12);
  }
}

TEST(Hyperplane, BasisLeavesOutTheLastOfTheAxesAlongWhichTheNormalIsLargest) {
  // Gram-Schmidt makes the matrix of the basis upper triangular on the axes that are not left out.
  for (int ternary = 0; ternary < 81; ++ternary) {
    const Eigen::Vector4d normal(ternary % 3 - 1, ternary / 3 % 3 - 1, ternary / 9 % 3 - 1,
                                 ternary / 27 - 1);
    if (normal.isZero()) continue;
    SCOPED_TRACE(normal.transpose());
    int leftOut = 3;
    while (normal[leftOut] == 0) --leftOut;
    const HyperplaneBasis basis = basisOf({normal, 0});
    EXPECT_EQ(basisOf({-normal, 0}).axes, basis.axes);
    Eigen::Matrix3d kept;
    Eigen::Matrix4d frame;
    frame << basis.axes, normal.transpose();
    for (int axis = 0, column = 0; axis < 4; ++axis) {
      if (axis != leftOut) kept.col(column++) = basis.axes.col(axis);
    }
    EXPECT_TRUE(kept.isUpperTriangular(1e-15)) << kept;
    EXPECT_TRUE((kept.diagonal().array() > 0.4).all()) << kept;
    EXPECT_EQ(basis.rightHanded, frame.determinant() > 0);
  }
}

TEST(Hyperplane, ZeroAndNonFiniteNormalsAreRefused) {
  EXPECT_FALSE(checkHyperplane({Eigen::Vector4d::Zero(), 1}));
  EXPECT_FALSE(checkHyperplane({{1, 0, 0, std::numeric_limits<double>::infinity()}, 1}));
  EXPECT_TRUE(checkHyperplane({{0, 0, 0, 1e-5}, 1}));
}

/// The 4-simplex at the origin and the unit points, with an attribute per vertex: t itself.
model::Mesh pentachoron() {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  model::Slab slab;
  slab.timeEnd = 1;
  slab.connectivity = connectivity;
  slab.vertices = {model::Point4::Zero(), model::Point4::UnitX(), model::Point4::UnitY(),
                   model::Point4::UnitZ(), model::Point4::UnitW()};
  slab.attributes = {
      model::makeAttribute<double>("t", model::Domain::Vertex, {0, 0, 0, 0, 1}),
      model::makeAttribute<std::uint8_t>("corner", model::Domain::Vertex, {0, 1, 2, 3, 4}),
      model::makeAttribute<std::int16_t>("cell", model::Domain::Cell, {10, 11, 12, 13, 14})};
  model::Mesh mesh;
  EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

TEST(Slice, PentachoronHasTheSimplexShrinkingToItsApex) {
  model::Mesh mesh = pentachoron();
  for (const double t : {0.0, 0.25, 0.5, 0.9}) {
    const auto slice = sliceAtTime(mesh, t);
    ASSERT_TRUE(slice);
    EXPECT_EQ(slice->mesh.vertices.size(), 4U);
    EXPECT_EQ(slice->mesh.triangles.size(), 4U);
    EXPECT_TRUE(isClosed(slice->mesh));
    EXPECT_NEAR(signedVolume(slice->mesh), std::pow(1 - t, 3) / 6, 1e-15);
  }
}

/// A cube that moves in three steps of 0.7, with layers at accumulated times: the last is at
/// 2.0999999999999996.
model::Mesh sweptOverSums() {
  model::ScrewRun run;
  run.duration = 0.7;
  run.screw.translation = {0, 0, 1};
  run.count = 3;
  model::Motion motion = *model::chainScrews(0, std::span(&run, 1));
  EXPECT_EQ(motion.timeEnd(), 2.1);
  motion.segments[2].timeEnd = 3 * 0.7;
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(fixtures::cube(2), motion, options, mesh));
  return mesh;
}

TEST(Slice, ATimeThatIsALayerButForRoundingIsTheLayer) {
  model::Mesh mesh = sweptOverSums();
  ASSERT_LT(timeSpanOf(mesh).end, 2.1);
  for (const double layer : {0.0, 0.7, 1.4, 2.1}) {
    for (const double time : {layer, layer * (1 + 3e-16), layer * (1 - 3e-16)}) {
      const auto slice = sliceAtTime(mesh, time);
      ASSERT_TRUE(slice) << slice.error().text();
      EXPECT_EQ(slice->mesh.vertices.size(), 8U);
      EXPECT_EQ(slice->mesh.triangles.size(), 12U);
    }
  }
  EXPECT_GT(sliceAtTime(mesh, 0.7 + 1e-9)->mesh.triangles.size(), 12U);
  EXPECT_FALSE(sliceAtTime(mesh, 2.1 + 1e-9));
}

TEST(Slice, ANormalAlongTimeOfEitherSignIsThatTime) {
  model::Mesh mesh = pentachoron();
  for (const double w : {1.0, -1.0, 2.5, -0.125}) {
    for (const double t : {0.0, 0.25, 1.0}) {
      const auto expected = sliceAtTime(mesh, t);
      const auto section = slice(mesh, {{0, 0, -0.0, w}, w * t});
      ASSERT_TRUE(section) << section.error().text();
      EXPECT_EQ(section->mesh.vertices, expected->mesh.vertices);
      EXPECT_EQ(section->mesh.triangles, expected->mesh.triangles);
      EXPECT_GE(signedVolume(section->mesh), 0);
    }
    const auto outside = slice(mesh, {{0, 0, 0, w}, 2 * w});
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().message, sliceAtTime(mesh, 2).error().message);
  }
}

TEST(Slice, OppositeNormalsGiveTheSameSolidFacingOutward) {
  model::Mesh mesh = pentachoron();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 50; ++i) {
    const Hyperplane one{{number(random), number(random), number(random), number(random)}, 0.1};
    const Hyperplane other{-one.normal, -one.offset};
    const double volume = signedVolume(slice(mesh, one)->mesh);
    EXPECT_GE(volume, 0);
    EXPECT_NEAR(signedVolume(slice(mesh, other)->mesh), volume, 1e-15);
  }
}

TEST(Slice, WhatIsNoHyperplaneIsRefused) {
  model::Mesh mesh = pentachoron();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Hyperplane& none :
       {Hyperplane{Eigen::Vector4d::Zero(), 0}, Hyperplane{Eigen::Vector4d::Zero(), 1},
        Hyperplane{{nan, 0, 0, 1}, 0}, Hyperplane{{0, 0, 0, infinity}, 0},
        Hyperplane{{1, 0, 0, 0}, nan}}) {
    EXPECT_EQ(slice(mesh, none).error().code, ErrorCode::InvalidInput);
    Slicer slicer(none);
    const auto put = slicer.put(mesh.slabs()[0]);
    ASSERT_FALSE(put);
    EXPECT_NE(put.error().message.find("hyperplane"), std::string::npos);
  }
}

TEST(Slice, SlabsThatAreNotSoundAreRefused) {
  const model::Slab good = pentachoron().slabs()[0];
  const auto refusalOf = [](const model::Slab& slab) {
    Slicer slicer(Hyperplane::atTime(0.5));
    const auto put = slicer.put(slab);
    EXPECT_TRUE(put || slicer.finish().mesh.vertices.empty());
    return put ? "(was accepted)" : put.error().message;
  };
  const auto withConnectivity = [&](auto change) {
    auto connectivity = *good.connectivity;
    change(connectivity);
    model::Slab slab = good;
    slab.connectivity = std::make_shared<model::Connectivity>(connectivity);
    return refusalOf(slab);
  };
  EXPECT_EQ(refusalOf(good), "(was accepted)");
  EXPECT_EQ(withConnectivity([](auto& c) { c.cells[3][2] = 5; }), "cell 3 has the vertex 5, of 5");
  EXPECT_EQ(withConnectivity([](auto& c) { c.cells[1][1] = 2; }), "cell 1 has the vertex 2 twice");
  EXPECT_NE(withConnectivity([](auto& c) { c.lowerCount = 6; }).find("layers of 6"),
            std::string::npos);
  EXPECT_NE(withConnectivity([](auto& c) { c.cells.pop_back(); }).find("attribute 'cell'"),
            std::string::npos);
  model::Slab slab = good;
  slab.connectivity = nullptr;
  EXPECT_EQ(refusalOf(slab), "has no connectivity");
  slab = good;
  slab.vertices.pop_back();
  EXPECT_EQ(refusalOf(slab), "has 4 vertices where its connectivity has 5");
  slab = good;
  slab.vertices[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusalOf(slab), "vertex 2 is (nan, 1, 0, 0)");
  slab = good;
  slab.attributes[0].values.pop_back();
  EXPECT_NE(refusalOf(slab).find("attribute 't' has 39 bytes"), std::string::npos);
}

TEST(Slice, AMeshWithoutSlabsHasNone) {
  model::Mesh nothing;
  EXPECT_EQ(sliceAtTime(nothing, 0).error().message, "the mesh has no slabs");
}

TEST(Slice, TheSameInEveryDirection) {
  model::Mesh mesh = pentachoron();
  for (int axis = 0; axis < 3; ++axis) {
    const auto section = slice(mesh, Hyperplane::across(axis, 0.25));
    EXPECT_TRUE(isClosed(section->mesh));
    EXPECT_NEAR(signedVolume(section->mesh), std::pow(0.75, 3) / 6, 1e-15);
  }
}

TEST(Hyperplane, IsTheSameForNormalsOfAnyLength) {
  const Hyperplane oblique{{0.3, -1.2, 0.7, 0.9}, 0.4};
  for (const int exponent : {-1000, -600, 3, 900}) {
    const auto longer = [&](double number) { return std::scalbn(number, exponent); };
    const Hyperplane same{oblique.normal.unaryExpr(longer), longer(oblique.offset)};
    ASSERT_TRUE(checkHyperplane(same));
    EXPECT_EQ(scaledHyperplane(same).normal, scaledHyperplane(oblique).normal);
    EXPECT_EQ(scaledHyperplane(same).offset, scaledHyperplane(oblique).offset);
    EXPECT_EQ(basisOf(same).axes, basisOf(oblique).axes);
  }
  EXPECT_FALSE(checkHyperplane({{0, 0, 0, 1e-300}, 1e300}));
}

TEST(Slice, ALongerNormalIsTheSameHyperplane) {
  model::Mesh mesh = pentachoron();
  const auto one = slice(mesh, {{1, 1, 1, 1}, 0.5});
  const auto ten = slice(mesh, {{10, 10, 10, 10}, 5});
  EXPECT_NEAR(signedVolume(one->mesh), signedVolume(ten->mesh), 1e-15);
  EXPECT_GT(signedVolume(one->mesh), 0);
}

TEST(Slice, VertexAttributesAreInterpolatedAndCellAttributesKept) {
  model::Mesh mesh = pentachoron();
  const auto slice = sliceAtTime(mesh, 0.25);
  ASSERT_EQ(slice->mesh.attributes.size(), 3U);
  const model::Attribute& t = slice->mesh.attributes[0];
  ASSERT_EQ(t.rows(), slice->mesh.vertices.size());
  for (std::size_t i = 0; i < t.rows(); ++i) {
    double value = 0;
    std::memcpy(&value, t.row(i), sizeof value);
    EXPECT_DOUBLE_EQ(value, 0.25);
  }
  EXPECT_EQ(slice->mesh.attributes[2].rows(), slice->mesh.triangles.size());
  EXPECT_TRUE(slice->losses.empty());
}

TEST(Slice, TimeOutsideSaysTheRange) {
  model::Mesh mesh = pentachoron();
  for (const double t : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    const auto slice = sliceAtTime(mesh, t);
    ASSERT_FALSE(slice);
    EXPECT_NE(slice.error().message.find("lasts from 0 to 1"), std::string::npos);
  }
}

TEST(Slice, MissingTheMeshIsEmpty) {
  model::Mesh mesh = pentachoron();
  const auto section = slice(mesh, Hyperplane::across(0, 5));
  ASSERT_TRUE(section);
  EXPECT_TRUE(section->mesh.triangles.empty());
}

TEST(Units, MillimetresAndInches) {
  EXPECT_EQ(model::metresPer("mm"), 0.001);
  EXPECT_EQ(model::metresPer("in"), 0.0254);
  EXPECT_FALSE(model::metresPer("cubit"));
}

/// Two slabs of cells that lie one after another along x, in several blocks. They close no solid,
/// which slicing does not ask.
std::vector<model::Slab> longSlabs(std::uint32_t layer, std::size_t cells) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<model::Slab> slabs;
  for (int k = 0; k < 2; ++k) {
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = 3 * layer;
    connectivity->lowerCount = layer;
    connectivity->upperCount = layer;
    std::uniform_int_distribution<std::uint32_t> part(0, 2);
    for (std::size_t i = 0; i < cells; ++i) {
      const auto at = static_cast<std::uint32_t>(i * (layer - 4) / cells);
      connectivity->cells.push_back({at + part(random) * layer, at + 1 + part(random) * layer,
                                     at + 2 + part(random) * layer, at + 3 + part(random) * layer});
    }
    model::Slab slab{static_cast<double>(k), k + 1.0, {}, connectivity, {}};
    for (std::uint32_t i = 0; i < 3 * layer; ++i) {
      const double along = (i % layer) / 1000.0;
      const double time = i < layer ? 0 : i < 2 * layer ? number(random) : 1;
      slab.vertices.emplace_back(along, number(random), number(random), k + time);
    }
    if (k > 0) std::ranges::copy(slabs.back().upperLayer(), slab.vertices.begin());
    slabs.push_back(std::move(slab));
  }
  return slabs;
}

/// The triangles of a mesh by their coordinates, in an order of their own.
std::vector<std::array<double, 9>> trianglesOf(const model::TriangleMesh& mesh) {
  std::vector<std::array<double, 9>> triangles;
  for (const model::Triangle& triangle : mesh.triangles) {
    const auto first = std::ranges::min_element(triangle, {}, [&](std::uint32_t corner) {
      const model::Point3& p = mesh.vertices[corner];
      return std::tuple(p[0], p[1], p[2]);
    });
    const auto begin = static_cast<std::size_t>(first - triangle.begin());
    std::array<double, 9> numbers{};
    for (std::size_t k = 0; k < 9; ++k) {
      numbers[k] = mesh.vertices[triangle[(begin + k / 3) % 3]][static_cast<int>(k % 3)];
    }
    triangles.push_back(numbers);
  }
  std::ranges::sort(triangles);
  return triangles;
}

TEST(Slice, OfAFileByBlocksIsThatOfTheMeshInMemory) {
  constexpr std::uint32_t kLayer = 70'000;
  constexpr std::size_t kCells = 200'000;
  model::Mesh mesh;
  formats::Metadata metadata;
  metadata.bodies = {{"long"}};
  const platform::TestFolder folder;
  const auto path = folder / "long.t4d";
  auto writer = formats::T4dWriter::create(path, metadata);
  for (const model::Slab& slab : longSlabs(kLayer, kCells)) {
    ASSERT_TRUE(mesh.put(slab));
    ASSERT_TRUE(writer->body(0).put(slab));
  }
  ASSERT_TRUE(writer->finish());
  const auto reader = formats::T4dReader::open(path);
  ASSERT_TRUE(reader);

  struct Case {
    Hyperplane hyperplane;
    std::uint64_t mostBlocks;
  };
  for (const auto& [hyperplane, mostBlocks] :
       {Case{Hyperplane::across(0, 10), 2}, Case{Hyperplane::across(0, 60.5), 4},
        Case{Hyperplane::across(1, 0.5), 8}, Case{{{1, 2, -3, 4}, 30}, 4},
        Case{Hyperplane::atTime(0.5), 4}, Case{Hyperplane::atTime(1), 4},
        Case{Hyperplane::across(0, 100), 0}}) {
    const auto whole = slice(mesh, hyperplane);
    const auto byBlocks = slice(reader->body(0), hyperplane);
    ASSERT_TRUE(whole && byBlocks);
    EXPECT_EQ(byBlocks->mesh.vertices.size(), whole->mesh.vertices.size());
    EXPECT_EQ(trianglesOf(byBlocks->mesh), trianglesOf(whole->mesh));
    EXPECT_LE(byBlocks->blocksRead, mostBlocks);
    EXPECT_EQ(byBlocks->blocksRead == 0, mostBlocks == 0);
    EXPECT_EQ(byBlocks->slabsSkipped, 2 - byBlocks->slabsRead);
    EXPECT_EQ(byBlocks->slabsRead == 0, mostBlocks == 0);
  }
  // The hyperplane cuts all blocks of both slabs.
  const auto through = slice(reader->body(0), Hyperplane::across(1, 0.5));
  ASSERT_TRUE(through);
  EXPECT_EQ(through->blocksRead, 8U);
  // There are no means, and so no prisms for a light slice.
  const auto light = LightSlicer(reader->body(0)).at(0.5);
  ASSERT_TRUE(light) << light.error().text();
  EXPECT_FALSE(light->light);
  EXPECT_EQ(light->whyExact, "its cells are stored in blocks, without means");
  EXPECT_EQ(trianglesOf(light->slice.mesh),
            trianglesOf(slice(mesh, Hyperplane::atTime(0.5))->mesh));
}

TEST(Slice, SkipsSlabsThatAHyperplaneMissesAndNoOthers) {
  // A solid that moves along x, as it is found in memory and in a file.
  const auto solid = fixtures::icosphere(1, 2);
  const model::ScrewRun run{5, {.translation = {10, 0, 0}}, 1};
  const auto motion = model::chainScrews(0, {&run, 1});
  model::Mesh mesh;
  formats::Metadata metadata;
  metadata.bodies = {{"ball"}};
  const platform::TestFolder folder;
  const auto path = folder / "ball.t4d";
  auto writer = formats::T4dWriter::create(path, metadata);
  model::Tee both({&mesh, &writer->body(0)});
  ASSERT_TRUE(mesh4d::sweep(solid, *motion, {.steps = mesh4d::StepsPerSegment{50}}, both));
  ASSERT_TRUE(writer->finish());
  const auto reader = formats::T4dReader::open(path);
  ASSERT_TRUE(reader);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  std::uint64_t skipped = 0;
  for (int i = 0; i < 90; ++i) {
    Hyperplane hyperplane{{number(random), number(random), number(random), number(random)},
                          8 * number(random)};
    if (i < 20) hyperplane = Hyperplane::across(0, 6 + 6 * number(random));
    // The cut is through a vertex, and along x through many.
    const model::Slab& slab = mesh.slabs()[1 + random() % 49];
    const model::Point4& vertex = slab.vertices[random() % slab.vertices.size()];
    if (i >= 60) hyperplane.offset = along(hyperplane.normal, vertex);
    if (i >= 75) hyperplane = Hyperplane::across(1 + i % 2, i % 3 == 0 ? 0 : vertex[1 + i % 2]);
    const auto whole = slice(mesh, hyperplane);
    const auto fromFile = slice(reader->body(0), hyperplane);
    ASSERT_TRUE(whole && fromFile);
    EXPECT_EQ(fromFile->mesh.vertices, whole->mesh.vertices);
    EXPECT_EQ(fromFile->mesh.triangles, whole->mesh.triangles);
    EXPECT_EQ(fromFile->slabsRead + fromFile->slabsSkipped, whole->slabsRead);
    skipped += fromFile->slabsSkipped;
  }
  EXPECT_GT(skipped, 500);
}

TEST(Slice, AVertexOfManyCellsIsCutLikeOthers) {
  // Cones over a polygon: each apex has 500 triangles, and the caps' apexes a thousand cells.
  const model::TriangleMesh mesh = fixtures::bipyramid(500);
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = 10;
  model::Mesh swept;
  mesh4d::SweepOptions options;
  options.steps = mesh4d::StepsPerSegment{2};
  options.caps = mesh4d::CapMethod::Cone;
  ASSERT_TRUE(sweep(mesh, *model::chainScrews(0, std::span(&run, 1)), options, swept));
  const auto across = slice(swept, Hyperplane::across(2, 0.25));
  ASSERT_TRUE(across) << across.error().text();
  EXPECT_TRUE(isClosed(across->mesh));
  // Every edge is cut once.
  std::set<std::array<double, 3>> places;
  for (const model::Point3& vertex : across->mesh.vertices) {
    places.insert({vertex.x(), vertex.y(), vertex.z()});
  }
  EXPECT_EQ(places.size(), across->mesh.vertices.size());
  const auto at = sliceAtTime(swept, 0.3);
  EXPECT_TRUE(isClosed(at->mesh));
}

}  // namespace
}  // namespace t4d::slice
