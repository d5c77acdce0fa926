#include <cmath>

#include <gtest/gtest.h>

#include "fixtures/fields.h"
#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::measure {
namespace {

using model::Point3;

TEST(SolidMeasures, OfABoxAreTheClosedFormFarFromTheOrigin) {
  for (const double away : {0.0, 1e3, 1e9}) {
    model::TriangleMesh box = fixtures::cube(1);
    for (Point3& vertex : box.vertices) {
      vertex = vertex.cwiseProduct(Point3(2, 4, 6)) + Point3(away, -away, 2 * away);
    }
    const SolidMeasures found = measuresOf(box);
    EXPECT_NEAR(found.volume, 48, 1e-12 * 48);
    EXPECT_NEAR(found.area, 2 * (8 + 12 + 24), 1e-11);
    EXPECT_LT((found.centroid - Point3(away, -away, 2 * away)).norm(), 1e-12 + 1e-15 * away);
    EXPECT_EQ(found.bounds.max - found.bounds.min, Point3(2, 4, 6));
    EXPECT_EQ(found.components, 1U);
    EXPECT_EQ(found.cavities, 0U);
    EXPECT_EQ(found.genus, 0);
  }
}

TEST(SolidMeasures, AreRefusedOfASliceThatIsNotClosed) {
  // A simplex without one of its five sides, which is there at any time but the first.
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {0, 1, 2, 3}};
  model::Slab slab;
  slab.timeEnd = 1;
  slab.vertices.push_back(model::Point4::Zero());
  for (int i = 0; i < 4; ++i) slab.vertices.push_back(model::Point4::Unit(i));
  slab.connectivity = connectivity;
  model::Mesh mesh;
  ASSERT_TRUE(mesh.put(slab));
  const std::vector<model::Body> bodies = {{"open", &mesh}};
  const auto found = measuresOfEach(bodies, std::vector<double>{0.3});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().text(),
            "body 'open': the slice at time 0.3 is not closed, so that it has no volume");
}

TEST(SolidMeasures, TellComponentsFromCavitiesAndCountHandles) {
  const SolidMeasures torus = measuresOf(fixtures::torus(2, 0.5, 24, 12));
  EXPECT_EQ(torus.components, 1U);
  EXPECT_EQ(torus.genus, 1);
  const SolidMeasures hollow = measuresOf(fixtures::hollowCube(3, 1));
  EXPECT_EQ(hollow.components, 1U);
  EXPECT_EQ(hollow.cavities, 1U);
  EXPECT_NEAR(hollow.volume, 26, 1e-12);
  const SolidMeasures boxes = measuresOf(fixtures::twoBoxes(1, 1));
  EXPECT_EQ(boxes.components, 2U);
  EXPECT_EQ(measuresOf({}).components, 0U);
  EXPECT_TRUE(measuresOf({}).bounds.empty());
  // The centroid of two solids is weighed by their volumes.
  SolidMeasures sum = measuresOf(fixtures::translated(fixtures::cube(1), {4, 0, 0}));
  sum.add(measuresOf(fixtures::translated(fixtures::cube(2), {-5, 0, 0})));
  EXPECT_NEAR(sum.volume, 9, 1e-12);
  EXPECT_LT((sum.centroid - Point3((4.0 - 40) / 9, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(sum.bounds.max.x(), 4.5);
  EXPECT_EQ(sum.bounds.min.x(), -6);
}

TEST(SolidMeasures, OfASolidThatIsFlatHaveTheMiddleOfItsBounds) {
  model::TriangleMesh flat = fixtures::translated(fixtures::cube(1), {4, 5, 6});
  for (Point3& vertex : flat.vertices) vertex.z() = 6;
  SolidMeasures sum;
  sum.add(measuresOf(flat));
  sum.add({});
  EXPECT_EQ(sum.volume, 0);
  EXPECT_LT((sum.centroid - Point3(4, 5, 6)).norm(), 1e-12);
}

TEST(SolidMeasures, FollowFieldsWhoseTopologyChanges) {
  for (const fixtures::Field& field : fixtures::allFields()) {
    if (field.topology.empty()) continue;
    SCOPED_TRACE(field.name);
    std::vector<double> frames;
    for (int i = 0; i <= 12; ++i) {
      frames.push_back(field.timeBegin + (field.timeEnd - field.timeBegin) * i / 12);
    }
    const auto source = voxel4d::sampledFrames(field.value, {1, Point3::Zero()}, field.box, frames);
    model::Mesh mesh;
    ASSERT_TRUE(voxel4d::weave(*source, {}, mesh));
    std::vector<double> times;
    // The times are in no order, and some of them come twice.
    for (const fixtures::Topology& expected : field.topology) times.push_back(expected.time);
    times.insert(times.end(), times.rbegin(), times.rend());
    const model::Body body{field.name, &mesh};
    const auto found = measuresAt({&body, 1}, times);
    ASSERT_TRUE(found) << found.error().text();
    for (std::size_t i = 0; i < times.size(); ++i) {
      const SolidMeasures& one = (*found)[i];
      EXPECT_EQ(one.time, times[i]);
      const auto slice = slice::sliceAtTime(mesh, times[i]);
      ASSERT_TRUE(slice);
      const double volume = signedVolume(slice->mesh);
      EXPECT_NEAR(one.volume, volume, 1e-12 * volume);
      const std::size_t k = i < field.topology.size() ? i : times.size() - 1 - i;
      const fixtures::Topology& expected = field.topology[k];
      EXPECT_EQ(one.components + one.cavities, static_cast<std::uint64_t>(expected.components))
          << times[i];
      EXPECT_EQ(one.genus, expected.genus) << times[i];
    }
  }
}

model::Mesh rest(const model::TriangleMesh& solid, double begin, double duration = 1) {
  model::ScrewRun run;
  run.duration = duration;
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, *model::chainScrews(begin, {&run, 1}),
                            {mesh4d::StepsPerSegment{3}, mesh4d::CapMethod::Cone}, mesh));
  return mesh;
}

TEST(SolidMeasures, OfEachBodyAddUpToThoseOfAll) {
  const model::Mesh early = rest(fixtures::cube(1), 0, 2);
  const model::Mesh late = rest(fixtures::cube(2), 1, 2);
  const std::vector<model::Body> bodies = {{"early", &early}, {"late", &late}};
  const std::vector<double> times = {2.5, 0.5, 1.5};
  const auto each = measuresOfEach(bodies, times);
  const auto all = measuresAt(bodies, times);
  ASSERT_TRUE(each && all);
  ASSERT_EQ(each->size(), 2U);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const SolidMeasures& first = (*each)[0][i];
    const SolidMeasures& second = (*each)[1][i];
    EXPECT_EQ(first.time, times[i]);
    EXPECT_EQ(second.time, times[i]);
    // A body that does not exist has nothing.
    EXPECT_EQ(first.components, times[i] < 2 ? 1U : 0U);
    EXPECT_EQ(second.components, times[i] > 1 ? 1U : 0U);
    EXPECT_EQ((*all)[i].components, first.components + second.components);
    EXPECT_EQ((*all)[i].volume, first.volume + second.volume);
  }
  EXPECT_FALSE(measuresOfEach(bodies, std::vector<double>{3.5}));
}

TEST(SolidMeasures, StopWhenTold) {
  const model::Mesh mesh = rest(fixtures::cube(1), 0);
  const model::Body bodies[] = {{"cube", &mesh}};
  const auto found =
      measuresAt(bodies, model::evenTimes({0, 1}, 100), [](double) { return false; });
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().message, "stopped");
}

TEST(SolidMeasures, OfSeveralBodiesAreThoseThatExist) {
  const model::Mesh early = rest(fixtures::cube(1), 0);
  const model::Mesh late = rest(fixtures::cube(2), 3);
  const model::Body bodies[] = {{"early", &early}, {"late", &late}};
  double most = 0;
  const auto found = measuresAt(bodies, std::vector<double>{3.5, 0.5, 2}, [&](double part) {
    most = std::max(most, part);
    return true;
  });
  ASSERT_TRUE(found);
  EXPECT_EQ(most, 1);
  EXPECT_NEAR((*found)[0].volume, 8, 1e-12);
  EXPECT_NEAR((*found)[1].volume, 1, 1e-12);
  EXPECT_EQ((*found)[2].volume, 0);
  EXPECT_EQ((*found)[2].components, 0U);
  for (const double time : {-0.5, 4.5, std::nan("")}) {
    EXPECT_FALSE(measuresAt(bodies, std::vector<double>{0.5, time})) << time;
  }
}

}  // namespace
}  // namespace t4d::measure
