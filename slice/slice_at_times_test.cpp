#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::slice {
namespace {

/// Counts how often each slab is read.
class Counted : public model::Source {
 public:
  explicit Counted(const model::Source& source) : source_(source) {}
  std::size_t slabCount() const override { return source_.slabCount(); }
  model::TimeSpan timeSpan(std::size_t index) const override { return source_.timeSpan(index); }
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override {
    ++reads[index];
    return source_.slab(index);
  }
  mutable std::map<std::size_t, int> reads;

 private:
  const model::Source& source_;
};

TEST(SliceAtTimes, GivesWhatSliceAtTimeGivesAndReadsEachSlabOnce) {
  model::Screw turn;
  turn.angleDegrees = 90;
  turn.translation = {1, 2, 3};
  const model::ScrewRun run{10, turn, 1};
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(fixtures::cube(2), *model::chainScrews(0, {&run, 1}), options, mesh));
  // Unsorted, twice the same, at both ends, in one slab, outside and no number.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> times = {7, 10, 0, 3.3, 3.31, 3.3, -1, 11, nan, 9.99};
  const Counted source(mesh);
  double fraction = 0;
  const auto slices = sliceAtTimes(source, times, [&](double done) {
    fraction = done;
    return true;
  });
  ASSERT_EQ(slices.size(), times.size());
  EXPECT_EQ(fraction, 1);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto expected = sliceAtTime(mesh, times[i]);
    ASSERT_EQ(slices[i].has_value(), expected.has_value()) << times[i];
    if (!expected) {
      EXPECT_EQ(slices[i].error().text(), expected.error().text());
      continue;
    }
    EXPECT_EQ(slices[i]->mesh.vertices, expected->mesh.vertices);
    EXPECT_EQ(slices[i]->mesh.triangles, expected->mesh.triangles);
  }
  for (const auto& [slab, reads] : source.reads) EXPECT_EQ(reads, 1) << slab;
  EXPECT_TRUE(sliceAtTimes(mesh, {}).empty());
}

}  // namespace
}  // namespace t4d::slice
