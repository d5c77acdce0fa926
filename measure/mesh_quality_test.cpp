#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/cell_quality.h"
#include "t4d/check.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using model::Point4;

/// A rotation of R^4 that depends on the seed.
Eigen::Matrix4d rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Matrix4d any = Eigen::Matrix4d::NullaryExpr([&] { return normal(random); });
  return Eigen::HouseholderQR<Eigen::Matrix4d>(any).householderQ();
}

TEST(CellQuality, OfTheRegularTetrahedronIsTheBestHoweverItLies) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    const Eigen::Matrix4d turn = rotation(random);
    const double size = std::exp2(static_cast<double>(random() % 600) - 300);
    const double timeScale = std::exp2(static_cast<double>(random() % 20) - 10);
    std::array<Point4, 4> corners = {Point4(1, 1, 1, 0), Point4(1, -1, -1, 0), Point4(-1, 1, -1, 0),
                                     Point4(-1, -1, 1, 0)};
    for (Point4& corner : corners) {
      corner = size * (turn * corner);
      corner[3] /= timeScale;
    }
    const CellQuality quality = qualityOf(corners, timeScale);
    EXPECT_NEAR(quality.volume / (8.0 / 3 * size * size * size), 1, 1e-12);
    EXPECT_NEAR(quality.edgeRatio, 1, 1e-12);
    EXPECT_NEAR(quality.radiusRatio, 1, 1e-12);
    const double angle = std::acos(1.0 / 3) * 180 / std::numbers::pi;
    EXPECT_NEAR(quality.smallestAngle, angle, 1e-11);
    EXPECT_NEAR(quality.largestAngle, angle, 1e-11);
    EXPECT_NEAR(quality.height, std::sqrt(2.0 / 3), 1e-12);
  }
}

TEST(CellQuality, OfTheCornerOfACubeIsItsClosedForm) {
  std::mt19937 random(8);
  for (int round = 0; round < 100; ++round) {
    const Eigen::Matrix4d turn = rotation(random);
    std::array<Point4, 4> corners = {Point4(0, 0, 0, 0), turn.col(0), turn.col(1), turn.col(2)};
    std::ranges::shuffle(corners, random);
    const CellQuality quality = qualityOf(corners, 1);
    EXPECT_NEAR(quality.volume, 1.0 / 6, 1e-14);
    EXPECT_NEAR(quality.edgeRatio, std::numbers::sqrt2, 1e-13);
    // The sphere around it is that of the cube; that within it has 3 V / area.
    const double inradius = 0.5 / (1.5 + std::numbers::sqrt3 / 2);
    EXPECT_NEAR(quality.radiusRatio, std::numbers::sqrt3 / 2 / (3 * inradius), 1e-12);
    EXPECT_NEAR(quality.smallestAngle, std::acos(1 / std::numbers::sqrt3) * 180 / std::numbers::pi,
                1e-11);
    EXPECT_NEAR(quality.largestAngle, 90, 1e-11);
    EXPECT_NEAR(quality.height, 1 / std::numbers::sqrt3 / std::numbers::sqrt2, 1e-12);
  }
}

TEST(CellQuality, OfAFlatCellIsTheWorst) {
  const std::array<Point4, 4> flat = {Point4(0, 0, 0, 0), Point4(1, 0, 0, 2), Point4(2, 0, 0, 4),
                                      Point4(0, 1, 0, 0)};
  const CellQuality quality = qualityOf(flat, 3);
  EXPECT_EQ(quality.volume, 0);
  EXPECT_TRUE(std::isinf(quality.radiusRatio));
  EXPECT_EQ(quality.height, 0);
  EXPECT_EQ(quality.smallestAngle, 0);
  EXPECT_EQ(quality.largestAngle, 180);
  const CellQuality point = qualityOf({flat[0], flat[0], flat[0], flat[0]}, 1);
  EXPECT_TRUE(std::isinf(point.edgeRatio));
}

TEST(CellQuality, DoesNotDependOnTheCellsThatAreMeasuredTogether) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 1000; ++round) {
    CellsTogether cells;
    for (auto& corners : cells) {
      for (Point4& corner : corners) corner = Point4::NullaryExpr([&] { return normal(random); });
      const auto kind = random() % 4;
      if (kind == 0) corners[2] = corners[1];
      if (kind == 1) corners[3] = (corners[0] + corners[1] + corners[2]) / 3;
      if (kind == 2) corners.fill(corners[0]);
    }
    const auto together = qualitiesOf(cells, 0.7);
    for (std::size_t k = 0; k < kCellsTogether; ++k) {
      const CellQuality alone = qualityOf(cells[k], 0.7);
      for (const QualityMeasure& measure : kQualityMeasures) {
        EXPECT_EQ(together[k].*measure.value, alone.*measure.value) << measure.name;
      }
    }
  }
}

TEST(CellQuality, KeepsTheHeightOfAThinCell) {
  for (const double height : {1e-3, 1e-7, 1e-11}) {
    const std::array<Point4, 4> thin = {Point4(0, 0, 0, 0), Point4(1, 0, 0, 0), Point4(0, 1, 0, 0),
                                        Point4(0.3, 0.3, 0, height)};
    const CellQuality quality = qualityOf(thin, 1);
    EXPECT_NEAR(quality.height / (height / std::numbers::sqrt2), 1, 1e-4);
    EXPECT_NEAR(quality.volume / (height / 6), 1, 1e-4);
  }
}

TEST(CellQuality, KeepsTheRatioOfANeedle) {
  // One edge along t, two corners aside of it by a width w.
  for (const double width : {1e-2, 1e-5, 1e-8, 1e-10}) {
    const std::array<Point4, 4> needle = {Point4(0, 0, 0, 0), Point4(0, 0, 0, 1),
                                          Point4(width, 0, 0, 0.3), Point4(0, width, 0, 0.6)};
    const double squared = width * width;
    const double circumradius =
        std::hypot((squared - 0.21) / (2 * width), (squared - 0.24) / (2 * width), 0.5);
    const double areas = 1 + 1 + std::sqrt(0.45 + squared) + std::sqrt(0.65 + squared);
    const double inradius = width / areas;
    const double expected = circumradius / (3 * inradius);
    std::mt19937 random(3);
    for (int round = 0; round < 10; ++round) {
      std::array<Point4, 4> corners = needle;
      std::ranges::shuffle(corners, random);
      EXPECT_NEAR(qualityOf(corners, 1).radiusRatio / expected, 1, 1e-4) << width;
    }
  }
}

TEST(Distribution, HasTheQuantilesOfTheSortedValues) {
  std::mt19937 random(9);
  for (int round = 0; round < 20; ++round) {
    std::lognormal_distribution<double> some(0, 0.5 + 0.25 * round);
    std::vector<double> values(1 + random() % 5000);
    Distribution one;
    Distribution other;
    for (double& value : values) {
      value = some(random);
      (random() % 3 == 0 ? one : other).add(value);
    }
    one.add(other);
    std::ranges::sort(values);
    EXPECT_EQ(one.count(), values.size());
    EXPECT_EQ(one.min(), values.front());
    EXPECT_EQ(one.max(), values.back());
    for (const double fraction : {0.01, 0.5, 0.99}) {
      const auto place =
          static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
      const double expected = values[std::max<std::size_t>(place, 1) - 1];
      EXPECT_NEAR(one.quantile(fraction) / expected, 1, 0.0021);
    }
  }
}

TEST(Distribution, HoldsAllNumbersThatAreNotNegative) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Distribution some;
  for (const double value : {1e-300, 3e-300, 1e300, 3e300}) some.add(value, 2);
  EXPECT_NEAR(some.quantile(0.5) / 3e-300, 1, 0.0021);
  EXPECT_NEAR(some.quantile(0.75) / 1e300, 1, 0.0021);
  some.add(0);
  some.add(-0.0);
  some.add(kInfinity);
  EXPECT_EQ(some.min(), 0);
  EXPECT_EQ(some.max(), kInfinity);
  EXPECT_EQ(some.quantile(0.01), 0);
  EXPECT_EQ(some.quantile(0.99), kInfinity);
  EXPECT_EQ(some.count(), 11U);
  const Distribution inner = some.positiveAndFinite();
  EXPECT_EQ(inner.count(), 8U);
  EXPECT_NEAR(inner.min() / 1e-300, 1, 0.0021);
  EXPECT_NEAR(inner.max() / 3e300, 1, 0.0021);
  EXPECT_EQ(Distribution().quantile(0.5), 0);
}

/// A cube of side 2 that moves by `velocity` during t = 0 to 4.
model::Mesh movingCube(const Eigen::Vector3d& velocity) {
  model::Screw screw;
  screw.translation = velocity;
  const std::vector<model::ScrewRun> runs = {{1, screw, 4}};
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, runs), options, mesh));
  return mesh;
}

TEST(MeanNormalSpeed, OfACubeIsAThirdOfItsSpeedAlongAnAxis) {
  for (const double speed : {0.0, 0.7, 2.1}) {
    const model::Mesh mesh = movingCube({0, speed, 0});
    const model::Body body{"cube", &mesh};
    EXPECT_NEAR(*meanNormalSpeed({&body, 1}), speed / 3, 1e-13);
  }
}

TEST(MeanNormalSpeed, OfASolidAtRestIsNothingWhereverItIs) {
  for (const double offset : {0.0, 1.0, 1e6, 1e9}) {
    model::TriangleMesh ball = fixtures::icosphere(1, 3);
    for (model::Point3& vertex : ball.vertices) vertex.array() += offset;
    // Posed, so that the layers differ by rounding.
    const std::vector<model::ScrewRun> runs = {
        {1, {.axisPoint = {3, 2, 1}, .axisDirection = {0.6, 0, 0.8}, .angleDegrees = 360}, 3}};
    mesh4d::SweepOptions options;
    options.steps = mesh4d::StepsPerSegment{1};
    options.caps = mesh4d::CapMethod::Cone;
    model::Mesh mesh;
    ASSERT_TRUE(mesh4d::sweep(ball, *model::chainScrews(0, runs), options, mesh));
    const model::Body body{"", &mesh};
    EXPECT_EQ(*meanNormalSpeed({&body, 1}), 0) << offset;
  }
}

TEST(MeshQuality, CountsEveryCellAndRanksTheWorst) {
  const model::Mesh mesh = movingCube({0.7, 0, 0});
  const model::Body body{"cube", &mesh};
  const auto quality = measureQuality({&body, 1}, {.timeScale = 0.5, .worst = 7});
  ASSERT_TRUE(quality);
  std::vector<double> ratios;
  std::uint64_t caps = 0;
  for (const model::Slab& slab : mesh.slabs()) {
    if (slab.timeBegin == slab.timeEnd) caps += slab.connectivity->cells.size();
    for (const model::Cell& cell : slab.connectivity->cells) {
      const auto at = [&](int k) { return slab.vertices[cell[k]]; };
      ratios.push_back(qualityOf({at(0), at(1), at(2), at(3)}, 0.5).radiusRatio);
    }
  }
  EXPECT_EQ(quality->cells(), ratios.size());
  EXPECT_EQ(quality->caps[0].count(), caps);
  std::ranges::sort(ratios, std::greater());
  ASSERT_EQ(quality->worst.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(quality->worst[i].quality.radiusRatio, ratios[i]);
  }
  EXPECT_EQ(quality->all(2).max(), ratios.front());
}

/// A slab of cells that need not bound anything.
class Cells : public model::Source {
 public:
  explicit Cells(std::size_t count) {
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = 5;
    connectivity->cells.assign(count, model::Cell{0, 1, 2, 3});
    slab_.timeEnd = 1;
    slab_.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 1}, {0, 0, 0, 1}};
    slab_.connectivity = std::move(connectivity);
  }
  std::size_t slabCount() const override { return 1; }
  model::TimeSpan timeSpan(std::size_t) const override { return {0, 1}; }
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t) const override {
    return std::make_shared<const model::Slab>(slab_);
  }

 private:
  model::Slab slab_;
};

TEST(MeshQuality, CountsTheLastCellAfterAPieceOfOthers) {
  for (const std::size_t count : {16'383U, 16'384U, 16'385U}) {
    const Cells cells(count);
    const model::Body body{"cells", &cells};
    const auto quality = measureQuality({&body, 1}, {});
    ASSERT_TRUE(quality) << quality.error().text();
    EXPECT_EQ(quality->cells(), count);
  }
}

TEST(MeshQuality, ProgressGoesOnFromBodyToBody) {
  const model::Mesh mesh = movingCube({0.7, 0, 0});
  const std::vector<model::Body> bodies = {{"a", &mesh}, {"b", &mesh}, {"c", &mesh}};
  std::vector<double> seen = {0};
  ASSERT_TRUE(measureQuality(bodies, {}, [&](double part) {
    seen.push_back(part);
    return true;
  }));
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_EQ(seen.back(), 1);
}

TEST(MeshQuality, DoesNotChangeWithTheUnitOfTime) {
  model::Mesh slow = movingCube({0.7, 0, 0});
  model::Mesh fast;
  for (model::Slab slab : slow.slabs()) {
    for (Point4& vertex : slab.vertices) vertex[3] /= 8;
    slab.timeBegin /= 8;
    slab.timeEnd /= 8;
    ASSERT_TRUE(fast.put(slab));
  }
  const model::Body a{"slow", &slow};
  const model::Body b{"fast", &fast};
  const auto one = measureQuality({&a, 1}, {.timeScale = *meanNormalSpeed({&a, 1})});
  const auto other = measureQuality({&b, 1}, {.timeScale = *meanNormalSpeed({&b, 1})});
  ASSERT_TRUE(one && other);
  EXPECT_NEAR(other->timeScale / one->timeScale, 8, 1e-13);
  for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
    for (const double fraction : {0.0, 0.01, 0.5, 0.99, 1.0}) {
      const double expected = one->all(k).quantile(fraction);
      EXPECT_NEAR(other->all(k).quantile(fraction), expected, 0.005 * expected);
    }
  }
}

TEST(MeshQuality, AttributesAreTheMeasuresOfTheCells) {
  const model::Mesh mesh = movingCube({0.7, 0, 0});
  for (const model::Slab& slab : mesh.slabs()) {
    const std::vector<QualityMeasure> both = {kQualityMeasures[2], kQualityMeasures[5]};
    model::Mesh added;
    QualitySink sink(both, 0.5, added);
    ASSERT_TRUE(sink.put(slab));
    EXPECT_TRUE(sink.replaced().empty());
    const model::Slab& with = added.slabs()[0];
    ASSERT_EQ(with.attributes.size(), slab.attributes.size() + 2);
    EXPECT_EQ(with.connectivity, slab.connectivity);
    EXPECT_EQ(with.attributes.back().name, "height");
    ASSERT_TRUE(model::checkSlab(with));
    const model::Cell& cell = slab.connectivity->cells.back();
    const auto at = [&](int k) { return slab.vertices[cell[k]]; };
    const CellQuality quality = qualityOf({at(0), at(1), at(2), at(3)}, 0.5);
    float found = 0;
    std::memcpy(&found, with.attributes.back().row(slab.connectivity->cells.size() - 1),
                sizeof found);
    EXPECT_EQ(found, static_cast<float>(quality.height));
  }
}

TEST(MeshQuality, AttributesThatAreThereAreReplaced) {
  const model::Mesh mesh = movingCube({0.7, 0, 0});
  const std::vector<QualityMeasure> both = {kQualityMeasures[2], kQualityMeasures[5]};
  model::Mesh once;
  QualitySink first(both, 0.5, once);
  for (const model::Slab& slab : mesh.slabs()) ASSERT_TRUE(first.put(slab));
  // One of them as an attribute of the connectivity.
  model::Mesh shared;
  for (model::Slab slab : once.slabs()) {
    auto connectivity = std::make_shared<model::Connectivity>(*slab.connectivity);
    connectivity->cellAttributes.push_back(slab.attributes.back());
    slab.attributes.pop_back();
    slab.connectivity = std::move(connectivity);
    ASSERT_TRUE(shared.put(slab));
  }
  model::Mesh twice;
  QualitySink second(both, 0.5, twice);
  for (const model::Slab& slab : shared.slabs()) ASSERT_TRUE(second.put(slab));
  EXPECT_EQ(second.replaced(), (std::set<std::string>{"height", "radius_ratio"}));
  for (std::size_t i = 0; i < once.slabCount(); ++i) {
    EXPECT_EQ(once.slabs()[i].attributes, twice.slabs()[i].attributes);
    EXPECT_EQ(*once.slabs()[i].connectivity, *twice.slabs()[i].connectivity);
  }
}

}  // namespace
}  // namespace t4d::measure
