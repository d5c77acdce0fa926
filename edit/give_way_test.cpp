#include "edit/give_way.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/sweep.h"

namespace t4d::edit {
namespace {

using model::Point3;

/// A ball that rises in eight steps.
model::Mesh risingBall() {
  const model::ScrewRun run{1, {.translation = {0, 0, 0.5}}, 8};
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(fixtures::icosphere(1, 2), *model::chainScrews(0, {&run, 1}),
                            {mesh4d::StepsPerSegment{8}, mesh4d::CapMethod::Cone}, mesh));
  return mesh;
}

std::map<LayerKey, double> layersOf(const VertexTracks& tracks) {
  std::map<LayerKey, double> layers;
  for (std::size_t k = 0; k <= tracks.steps(); ++k) layers[{k, 0}] = tracks.layerTime(k);
  return layers;
}

/// (1 - x^2)^2 up to 1.
double falloff(double x) { return x < 1 ? std::pow(1 - x * x, 2) : 0; }

TEST(GiveWay, APushSpreadsInSpaceAndTimeAsTheFormulaSays) {
  const model::Mesh mesh = risingBall();
  const auto tracks = VertexTracks::of(mesh);
  ASSERT_TRUE(tracks) << tracks.error().text();
  const std::map<LayerKey, double> layers = layersOf(*tracks);
  const std::uint32_t pushed = 5;
  const std::size_t at = 3;
  const Point3 along(0.6, 0, 0.8);
  const Pushes pushes = {{{at, 0}, {{pushed, {0.1, along}}}}};
  const Spread by{.space = 0.9, .time = 3};
  const auto moved = spread(*tracks, layers, pushes, by);
  ASSERT_TRUE(moved) << moved.error().text();
  std::size_t count = 0;
  for (const auto& [key, time] : layers) {
    const auto places = placesAt(*tracks, key);
    ASSERT_TRUE(places);
    const auto layer = moved->find(key);
    for (std::uint32_t i = 0; i < places->size(); ++i) {
      const double depth = 0.1 * falloff(((*places)[i] - (*places)[pushed]).norm() / by.space) *
                           falloff(std::abs(time - layers.at({at, 0})) / by.time);
      Point3 found = Point3::Zero();
      if (layer != moved->end()) {
        for (const auto& [vertex, displacement] : layer->second) {
          if (vertex == i) found = displacement;
        }
      }
      EXPECT_NEAR((found - depth * along).norm(), 0, 1e-12) << i << " at " << time;
      count += depth > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(count, 20U);
}

TEST(GiveWay, WithStayNothingGoesBack) {
  const model::Mesh mesh = risingBall();
  const auto tracks = VertexTracks::of(mesh);
  ASSERT_TRUE(tracks);
  const std::map<LayerKey, double> layers = layersOf(*tracks);
  const Pushes pushes = {{{3, 0}, {{5, {0.1, {1, 0, 0}}}}}};
  const auto moved = spread(*tracks, layers, pushes, {.space = 0.9, .time = 3, .stay = true});
  ASSERT_TRUE(moved);
  for (std::size_t k = 3; k <= 8; ++k) {
    ASSERT_TRUE(moved->contains({k, 0})) << k;
    EXPECT_EQ(moved->at({k, 0}), moved->at({3, 0})) << k;
  }
}

}  // namespace
}  // namespace t4d::edit
