#include <cstring>

#include <gtest/gtest.h>

#include "convert/frame_slices.h"
#include "fixtures/solids.h"
#include "platform/test_folder.h"
#include "t4d/convert.h"
#include "t4d/sweep.h"

namespace t4d::convert {
namespace {

/// A cube at rest from `begin` on, for a unit of time.
model::Mesh cubeFrom(double begin) {
  const model::ScrewRun rest{1, {}, 1};
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(begin, std::span(&rest, 1)),
                            options, mesh));
  return mesh;
}

class Flipbook : public testing::Test {
 protected:
  Result<FrameSlicesReport> write(std::span<const model::Body> bodies,
                                  const std::vector<double>& times,
                                  slice::SliceDetail detail = slice::SliceDetail::Light) {
    FlipbookOptions options;
    options.detail = detail;
    return writeFlipbook(bodies, times, folder_ / "out.glb", options);
  }
  bool written() const { return std::filesystem::exists(folder_ / "out.glb"); }

 private:
  platform::TestFolder folder_;
};

TEST_F(Flipbook, ShowsTheBodiesThatExist) {
  model::Mesh first = cubeFrom(0);
  model::Mesh second = cubeFrom(0.5);
  model::Mesh nothing;
  const std::vector<model::Body> bodies = {
      {"first", &first}, {"nothing", &nothing}, {"second", &second}};
  const auto light = write(bodies, {0, 0.5, 1.5});
  ASSERT_TRUE(light) << light.error().text();
  EXPECT_EQ(light->frames, 3U);
  EXPECT_EQ(light->triangles, 4 * 12U);
  EXPECT_TRUE(light->light);
  EXPECT_TRUE(light->notices.empty());
  const auto report = write(bodies, {0, 0.5, 1.5}, slice::SliceDetail::Exact);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->frames, 3U);
  EXPECT_FALSE(report->light);
  // 12 at a layer; between layers every triangle's prism gives 6.
  EXPECT_EQ(report->triangles, 3 * 12U + 6 * 12U);
  EXPECT_TRUE(written());
}

TEST(PlaybackRates, AreTheMeshsTimeInASecondOfPlayback) {
  const auto near = [](std::vector<double> found, std::vector<double> expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-12);
  };
  near(playbackRates(std::vector<double>{1, 1.5, 2, 2.5}, 24), {12, 12, 12, 12});
  near(playbackRates(std::vector<double>{0, 1, 4, 9}, 10), {10, 20, 40, 50});
  near(playbackRates(std::vector<double>{1, 0}, 1), {-1, -1});
}

/// A cube that goes 3 in a unit of time, shown backward and at half the speed.
TEST(FrameVelocity, IsPerSecondOfPlayback) {
  model::Screw screw;
  screw.translation = {3, 0, 0};
  const model::ScrewRun run{1, screw, 1};
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, {&run, 1}), options, mesh));
  const model::Body body{"cube", &mesh};
  const std::vector<double> times = {0.8, 0.6, 0.4};
  for (const bool attributes : {false, true}) {
    const auto report = forEachFrame(
        {&body, 1}, times,
        {.velocity = FrameVelocity{.most = 2.5, .timeUnits = playbackRates(times, 2.5)},
         .attributes = attributes},
        [&](std::size_t, std::span<const formats::NamedMesh> meshes) -> Result<void> {
          const auto& given = meshes.front().mesh.attributes;
          EXPECT_EQ(given.size() > 1, attributes);
          const model::Attribute& velocity = given.back();
          EXPECT_EQ(velocity.name, "velocity");
          for (std::size_t row = 0; row < velocity.rows(); ++row) {
            double x = 0;
            std::memcpy(&x, velocity.row(row), sizeof(x));
            EXPECT_NEAR(x, -1.25, 1e-12);  // 3, at most 2.5, times -0.2 * 2.5
          }
          return {};
        });
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_NEAR(report->maxSpeed, 1.25, 1e-12);
    EXPECT_GT(report->clamped, 0U);
  }
}

TEST_F(Flipbook, OfNothingIsRefused) {
  model::Mesh nothing;
  const std::vector<model::Body> empty = {{"nothing", &nothing}};
  for (const std::span<const model::Body> bodies :
       {std::span<const model::Body>(), std::span(empty)}) {
    const model::TimeSpan span = model::timeSpanOf(bodies);
    EXPECT_EQ(span.begin, 0);
    EXPECT_EQ(span.end, 0);
    const auto report = write(bodies, {0});
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().message, "there is nothing to show: no body has a slab");
  }
  model::Mesh cube = cubeFrom(0);
  const std::vector<model::Body> bodies = {{"cube", &cube}};
  EXPECT_EQ(write(bodies, {}).error().code, ErrorCode::InvalidInput);
  EXPECT_FALSE(written());
}

TEST_F(Flipbook, TimesBeforeAndAfterAllBodiesAreRefused) {
  model::Mesh cube = cubeFrom(0.1);
  const std::vector<model::Body> bodies = {{"cube", &cube}};
  EXPECT_TRUE(write(bodies, {0.1 - 1e-17, 1.1 + 2e-16}));
  for (const double time : {0.0, 1.2}) {
    EXPECT_NE(write(bodies, {0.5, time}).error().message.find("lasts from 0.1 to 1.1"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace t4d::convert
