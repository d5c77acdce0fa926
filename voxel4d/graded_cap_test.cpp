#include "voxel4d/graded_cap.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/weave.h"

namespace t4d::voxel4d {
namespace {

using SolidField = std::function<double(const Eigen::Vector3d& point)>;

/// Equal frames of a cube of `blocks` blocks along each axis around the origin, where the field is
/// negative inside; everything else is outside.
class SolidFrames : public FrameSource {
 public:
  /// The most blocks along an axis of a tile; 0 for none.
  std::int32_t maxTile = 8;
  bool values = false;
  bool firstIsEmpty = false;

  SolidFrames(std::int32_t blocks, SolidField field)
      : half_(blocks / 2), field_(std::move(field)) {}

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return 2; }
  Result<Frame> frame(std::size_t index) override {
    Frame frame;
    frame.time = 1.0 + static_cast<double>(index);
    frame.outsideValue = values ? 1 : 0;
    if (firstIsEmpty && index == 0) return frame;
    auto memory = std::make_shared<std::vector<std::unique_ptr<std::array<double, 512>>>>();
    for (unsigned d = 0; d < 8; ++d) {
      add(neighbour({-half_, -half_, -half_}, d, half_), half_, frame, *memory);
    }
    const auto byCoord = [](const auto& a, const auto& b) { return a.coord < b.coord; };
    std::sort(frame.blocks.begin(), frame.blocks.end(), byCoord);
    std::sort(frame.tiles.begin(), frame.tiles.end(), byCoord);
    frame.owner = memory;
    return frame;
  }

 private:
  using Memory = std::vector<std::unique_ptr<std::array<double, 512>>>;

  bool isSolid(const Coord& coord, std::int32_t size) const {
    const std::int32_t n = kBlockSize * size;
    for (std::int32_t x = 0; x < n; ++x) {
      for (std::int32_t y = 0; y < n; ++y) {
        for (std::int32_t z = 0; z < n; ++z) {
          if (at(coord, x, y, z) >= 0) return false;
        }
      }
    }
    return true;
  }

  double at(const Coord& block, std::int32_t x, std::int32_t y, std::int32_t z) const {
    return field_({static_cast<double>(kBlockSize * block.x + x),
                   static_cast<double>(kBlockSize * block.y + y),
                   static_cast<double>(kBlockSize * block.z + z)});
  }

  void add(const Coord& coord, std::int32_t size, Frame& frame, Memory& memory) const {
    if (size <= maxTile && isSolid(coord, size)) {
      frame.tiles.push_back({coord, size, values ? -1.0 : 0});
    } else if (size > 1) {
      for (unsigned d = 0; d < 8; ++d) {
        add(neighbour(coord, d, size / 2), size / 2, frame, memory);
      }
    } else {
      addBlock(coord, frame, memory);
    }
  }

  void addBlock(const Coord& coord, Frame& frame, Memory& memory) const {
    Block block{coord, {}, {}};
    auto& of = *memory.emplace_back(std::make_unique<std::array<double, 512>>());
    bool any = false;
    for (unsigned i = 0; i < 512; ++i) {
      of[i] = at(coord, static_cast<std::int32_t>(i >> 6U), static_cast<std::int32_t>(i >> 3U & 7U),
                 static_cast<std::int32_t>(i & 7U));
      if (of[i] >= 0) continue;
      any = true;
      block.inside[i >> 6U] |= std::uint64_t{1} << (i & 63U);
    }
    if (values) block.values.doubles = of.data();
    if (any) frame.blocks.push_back(block);
  }

  std::int32_t half_;
  SolidField field_;
  Lattice lattice_ = {0.25, {1, -2, 3}};
};

struct Capped {
  WeaveReport report;
  model::Mesh mesh;
  measure::MeshReport judged;
};

Capped wovenWith(CapStyle caps, FrameSource& frames) {
  Capped result;
  const auto report = weave(frames, {caps}, result.mesh);
  EXPECT_TRUE(report) << report.error().text();
  if (report) result.report = *report;
  const auto judged = measure::checkMesh(result.mesh, {.vertexLinks = true});
  EXPECT_TRUE(judged) << judged.error().text();
  if (judged) result.judged = *judged;
  return result;
}

void expectValid(const Capped& result) {
  EXPECT_TRUE(result.judged.closed && result.judged.oriented);
  EXPECT_TRUE(result.judged.vertexLinksOk.value_or(false));
  EXPECT_EQ(result.judged.degenerateCells, 0U);
  EXPECT_EQ(result.judged.issues.errors, 0U) << result.judged.issues.issues.front().message;
}

/// Both caps fill the same solid. The cells of a cap add up to that solid's volume only if none
/// overlap: all have the same orientation, since the mesh is oriented and encloses as much.
void expectSameSolid(const Capped& flat, const Capped& graded) {
  expectValid(flat);
  expectValid(graded);
  constexpr double kRounding = 1e-12;
  const double volume = flat.judged.boundaryVolume;
  EXPECT_NEAR(graded.judged.boundaryVolume, volume, kRounding * volume);
  EXPECT_NEAR(graded.judged.hypervolume, flat.judged.hypervolume, kRounding * volume);
  EXPECT_EQ(graded.judged.components, flat.judged.components);
  EXPECT_LE(graded.judged.tetrahedra, flat.judged.tetrahedra);
  // The slices are the same, too.
  ASSERT_EQ(graded.mesh.slabCount(), 3U);
  const auto& between = flat.mesh.slabs()[1];
  EXPECT_EQ(graded.mesh.slabs()[1].vertices, between.vertices);
  EXPECT_EQ(*graded.mesh.slabs()[1].connectivity, *between.connectivity);
  for (const std::size_t cap : {0U, 2U}) {
    const model::Slab& slab = graded.mesh.slabs()[cap];
    EXPECT_TRUE(model::checkSlab(slab));
    EXPECT_TRUE(std::ranges::equal(slab.lowerLayer(), flat.mesh.slabs()[cap].lowerLayer()));
    EXPECT_TRUE(std::ranges::equal(slab.upperLayer(), flat.mesh.slabs()[cap].upperLayer()));
    EXPECT_EQ(slab.connectivity->means.size(), 0U);
  }
}

/// A few boxes and balls, with balls cut out and grains of single points added and removed.
SolidField randomSolid(unsigned seed, double reach) {
  struct Part {
    Eigen::Vector3d centre;
    Eigen::Vector3d halfSize;
    bool box;
    bool adds;
  };
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Part> parts;
  const unsigned count = 2 + seed % 5;
  for (unsigned i = 0; i < count; ++i) {
    Part part;
    for (int k = 0; k < 3; ++k) {
      part.halfSize[k] = between(0.1, 0.7) * reach;
      const double room = reach - part.halfSize[k] - 1;
      part.centre[k] = between(-room, room);
    }
    part.box = between(0, 1) < 0.5;
    part.adds = i < 2 || between(0, 1) < 0.4;
    if (!part.adds) part.halfSize *= 0.4;
    parts.push_back(part);
  }
  const unsigned grains = seed % 3 == 0 ? 0 : 40 << seed % 7;  // one point in so many is turned
  return [=](const Eigen::Vector3d& point) {
    double field = 1;
    for (const Part& part : parts) {
      const Eigen::Vector3d from = (point - part.centre).cwiseQuotient(part.halfSize);
      const double distance = (part.box ? from.cwiseAbs().maxCoeff() : from.norm()) - 1;
      field = part.adds ? std::min(field, distance) : std::max(field, -distance);
    }
    if (field == 0) field = 1e-3;
    if (grains != 0 && point.cwiseAbs().maxCoeff() < reach - 1) {
      const Coord at{static_cast<std::int32_t>(point.x()), static_cast<std::int32_t>(point.y()),
                     static_cast<std::int32_t>(point.z())};
      if ((CoordHash()(at) ^ seed) % grains == 0) field = -field;
    }
    return field;
  };
}

TEST(GradedCap, FillsTheSolidOfAFlatCapWithoutOverlap) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    SolidFrames frames(4, randomSolid(seed, 16));
    frames.values = seed % 2 == 0;
    frames.maxTile = static_cast<std::int32_t>(seed % 3);
    expectSameSolid(wovenWith(CapStyle::Flat, frames), wovenWith(CapStyle::Graded, frames));
  }
}

TEST(GradedCap, LargeCubesMeetUnitCubes) {
  // The octree has cubes of 16 points; points are missing beside their faces and edges.
  const std::vector<Coord> missing = {{-17, 5, 3}, {-17, 16, 0}, {9, -17, -17}, {17, 17, 17}};
  const auto solid = [&](const Eigen::Vector3d& point) {
    const Coord at{static_cast<std::int32_t>(point.x()), static_cast<std::int32_t>(point.y()),
                   static_cast<std::int32_t>(point.z())};
    return std::ranges::find(missing, at) != missing.end() ? 1.0
                                                           : point.cwiseAbs().maxCoeff() - 23.5;
  };
  SolidFrames frames(8, solid);
  expectSameSolid(wovenWith(CapStyle::Flat, frames), wovenWith(CapStyle::Graded, frames));
}

TEST(GradedCap, ABoxIsEightCubes) {
  // Unit squares on the outside, and fans in the three faces of each cube between them.
  constexpr int kSide = 16;
  SolidFrames frames(
      8, [](const Eigen::Vector3d& p) { return p.cwiseAbs().maxCoeff() - (kSide + 0.5); });
  constexpr int kCubes = 8 * (6 * kSide * kSide + 3 * (2 * kSide + 2));
  constexpr int kUnitCubes = 6 * (2 * kSide) * (2 * kSide) * (2 * kSide);
  const Capped flat = wovenWith(CapStyle::Flat, frames);
  for (const std::int32_t maxTile : {0, 1, 2}) {
    frames.maxTile = maxTile;
    const Capped graded = wovenWith(CapStyle::Graded, frames);
    expectSameSolid(flat, graded);
    for (const std::size_t end : {0U, 1U}) {
      EXPECT_EQ(graded.report.capTetrahedra[end],
                flat.report.capTetrahedra[end] - kUnitCubes + kCubes);
    }
  }
}

TEST(GradedCap, DependsOnThePointsInsideAlone) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SolidFrames frames(8, randomSolid(seed, 32));
    std::vector<model::Mesh> meshes(3);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      frames.maxTile = std::array{0, 1, 4}[i];
      ASSERT_TRUE(weave(frames, {CapStyle::Graded}, meshes[i]));
      for (std::size_t slab = 0; slab < meshes[0].slabCount(); ++slab) {
        EXPECT_EQ(meshes[i].slabs()[slab].vertices, meshes[0].slabs()[slab].vertices);
        EXPECT_EQ(*meshes[i].slabs()[slab].connectivity, *meshes[0].slabs()[slab].connectivity);
      }
    }
  }
}

TEST(GradedCap, SameBytesForAnyNumberOfThreads) {
  SolidFrames frames(8, randomSolid(5, 32));
  std::vector<model::Mesh> meshes(2);
  for (const std::size_t threads : {1U, 5U}) {
    const model::ThreadLimit control(threads);
    ASSERT_TRUE(weave(frames, {CapStyle::Graded}, meshes[threads == 1 ? 0 : 1]));
  }
  for (const std::size_t cap : {0U, 2U}) {
    EXPECT_EQ(meshes[1].slabs()[cap].vertices, meshes[0].slabs()[cap].vertices);
    EXPECT_EQ(*meshes[1].slabs()[cap].connectivity, *meshes[0].slabs()[cap].connectivity);
  }
}

TEST(GradedCap, CellsGrowLikeTheSurface) {
  const auto cellsOfBall = [](CapStyle caps, double radius, std::int32_t blocks) {
    SolidFrames frames(blocks, [&](const Eigen::Vector3d& point) { return point.norm() - radius; });
    frames.values = true;
    model::Mesh mesh;
    const auto report = weave(frames, {caps}, mesh);
    EXPECT_TRUE(report) << report.error().text();
    return static_cast<double>(report->capTetrahedra[0]);
  };
  const double flat = cellsOfBall(CapStyle::Flat, 30.3, 8) / cellsOfBall(CapStyle::Flat, 15.15, 4);
  const double graded =
      cellsOfBall(CapStyle::Graded, 60.6, 16) / cellsOfBall(CapStyle::Graded, 30.3, 8);
  EXPECT_NEAR(graded, 4, 0.3);
  EXPECT_GT(flat, 6.5);
}

TEST(GradedCap, OnePointInsideAndNoneAtAll) {
  SolidFrames point(4, [](const Eigen::Vector3d& p) { return p.isZero() ? -1.0 : 1.0; });
  const Capped one = wovenWith(CapStyle::Graded, point);
  expectSameSolid(wovenWith(CapStyle::Flat, point), one);
  // An octahedron around the point.
  EXPECT_EQ(one.report.capTetrahedra, (std::array<std::uint64_t, 2>{8, 8}));

  point.firstIsEmpty = true;
  const Capped appears = wovenWith(CapStyle::Graded, point);
  expectSameSolid(wovenWith(CapStyle::Flat, point), appears);
  EXPECT_EQ(appears.report.capTetrahedra, (std::array<std::uint64_t, 2>{0, 8}));
}

}  // namespace
}  // namespace t4d::voxel4d
