#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "formats/gltf/gltf_animation.h"
#include "platform/test_folder.h"
#include "t4d/convert.h"
#include "t4d/sweep.h"

namespace t4d::convert {
namespace {

/// A solid whose vertices move at random, with keys 0.25 apart from `begin` on.
model::Mesh shaken(const model::TriangleMesh& solid, std::uint32_t seed, int keyCount,
                   double begin = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> offset(0, 0.3);
  std::vector<model::StoredKeys::Key> keys;
  for (int key = 0; key < keyCount; ++key) {
    keys.push_back({begin + 0.25 * key, solid.vertices});
    for (model::Point3& point : keys.back().positions) {
      point += model::Point3(offset(random) + key, offset(random), offset(random));
    }
  }
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, model::StoredKeys(std::move(keys)), options, mesh));
  return mesh;
}

class MorphFlipbook : public testing::Test {
 protected:
  /// It plays at the speed of the mesh's time.
  Result<FrameSlicesReport> write(const std::vector<model::Body>& bodies, double begin, double end,
                                  const formats::MeshWriteOptions& how = {}) {
    FlipbookOptions options;
    options.framesPerSecond = 1 / (end - begin);
    options.write = how;
    return writeMorphFlipbook(bodies, std::vector{begin, end}, path_, options);
  }
  Result<formats::AnimatedScene> read() const {
    const auto file = formats::readInputFile(path_);
    if (!file) return file.error();
    return formats::readGltfAnimation(*file, {"", "", 1e-5, /*edgeFactor=*/0});
  }

 private:
  platform::TestFolder folder_;
  std::filesystem::path path_ = folder_ / "out.glb";
};

TEST_F(MorphFlipbook, IsTheLightSliceAtAnyTime) {
  const model::TriangleMesh solids[] = {fixtures::cube(2), fixtures::torus(3, 1, 9, 5)};
  for (const model::TriangleMesh& solid : solids) {
    for (const int keys : {2, 3, 9}) {
      const model::Mesh mesh = shaken(solid, static_cast<std::uint32_t>(keys), keys);
      // The span begins within the first slab.
      const double begin = 0.1;
      const double end = 0.25 * (keys - 1);
      formats::MeshWriteOptions how;
      how.center = {0.5, -1, 2};
      const auto report = write({{"solid", &mesh}}, begin, end, how);
      ASSERT_TRUE(report) << report.error().text();
      EXPECT_EQ(report->triangles, solid.triangles.size());
      EXPECT_GT(report->distance, 0);
      const auto scene = read();
      ASSERT_TRUE(scene) << scene.error().text();
      ASSERT_EQ(scene->bodies.size(), 1U);
      const formats::AnimatedBody& body = scene->bodies.front();
      EXPECT_EQ(body.mesh.triangles, solid.triangles);
      ASSERT_EQ(body.runs.size(), 1U);
      const model::VertexKeys& run = *body.runs.front();
      // Nothing is added between two layers: what is played is straight there, as the light slice.
      EXPECT_EQ(run.count(), static_cast<std::uint64_t>(keys) + 1);
      std::vector<model::Point3> found(solid.vertices.size());
      const slice::LightSlicer slicer(mesh);
      for (std::uint64_t key = 0; key < run.count(); ++key) {
        ASSERT_TRUE(run.positions(key, found));
        const auto expected = slicer.at(std::min(begin + run.time(key), end));
        ASSERT_TRUE(expected) << expected.error().text();
        for (std::size_t i = 0; i < found.size(); ++i) {
          const model::Point3& place = expected->slice.mesh.vertices[i];
          EXPECT_NEAR((found[i] - place).norm(), 0, 1e-6 * (10 + place.norm()));
        }
      }
    }
  }
}

TEST_F(MorphFlipbook, ShowsABodyAtItsTimes) {
  const model::Mesh early = shaken(fixtures::cube(2), 1, 3);
  const model::Mesh late = shaken(fixtures::cube(2), 2, 3, 5);
  ASSERT_TRUE(write({{"early", &early}, {"late", &late}}, 0, 5.5));
  auto scene = read();
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_EQ(scene->bodies.size(), 2U);
  // Bodies that exist at none of the times are left out.
  const auto report = write({{"early", &early}, {"late", &late}}, 5, 5.5);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->triangles, 12U);
  EXPECT_EQ(read()->bodies.size(), 1U);
}

TEST_F(MorphFlipbook, OfABodyThatDoesNotKeepItsTrianglesIsRefused) {
  const model::TriangleMesh cube = fixtures::cube(2);
  const auto why = [&](const model::Mesh& mesh) {
    const auto report =
        write({{"solid", &mesh}}, mesh.slabs().front().timeBegin, mesh.slabs().back().timeEnd);
    EXPECT_FALSE(report);
    return report ? std::string() : report.error().message;
  };
  mesh4d::SweepOptions three;
  three.caps = mesh4d::CapMethod::Cone;
  three.prism = mesh4d::PrismSplit::Three;
  const model::ScrewRun rest{1, {}, 1};
  model::Mesh staircase;
  ASSERT_TRUE(mesh4d::sweep(cube, *model::chainScrews(0, {&rest, 1}), three, staircase));
  EXPECT_NE(why(staircase).find("body 'solid' does not keep its triangles: at time 0, its slab "
                                "does not consist of prisms"),
            std::string::npos);
  model::Mesh changing;
  const model::Mesh second = shaken(fixtures::torus(3, 1, 9, 5), 4, 2, 0.25);
  for (const model::Mesh& part : {shaken(cube, 3, 2), second}) {
    for (const model::Slab& slab : part.slabs()) {
      if (slab.timeEnd > slab.timeBegin) {
        ASSERT_TRUE(changing.put(slab));
      }
    }
  }
  EXPECT_NE(why(changing).find("at time 0.25, its triangles change"), std::string::npos);
}

}  // namespace
}  // namespace t4d::convert
