#include "voxel4d/point_field.h"

#include <cmath>

#include <gtest/gtest.h>
#include <openvdb/io/File.h>

#include "fixtures/solids.h"
#include "measure/visit_fields.h"
#include "platform/test_folder.h"
#include "t4d/envelope.h"
#include "t4d/sweep.h"
#include "voxel4d/vdb_file.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_voxel.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;

/// The only grid of a file.
template <class Grid>
typename Grid::Ptr readGrid(const std::filesystem::path& path) {
  initializeOpenVdb();
  openvdb::io::File file(path.string());
  file.open();
  const auto grids = file.getGrids();
  EXPECT_EQ(grids->size(), 1U);
  auto grid = openvdb::gridPtrCast<Grid>(grids->front());
  EXPECT_TRUE(grid);
  return grid;
}

PointField fieldOf(const measure::SpaceLattice& lattice) {
  PointField field;
  field.name = "field";
  field.lattice.voxelSize = lattice.spacing;
  for (int axis = 0; axis < 3; ++axis) {
    field.lattice.origin[axis] = lattice.at[axis].front();
    field.counts[axis] = static_cast<std::uint32_t>(lattice.at[axis].size());
  }
  return field;
}

TEST(PointField, IsReadAsItWasWritten) {
  const platform::TestFolder dir;
  for (const bool whole : {false, true}) {
    PointField field;
    field.name = "thirds";
    field.lattice = {0.25, Point3(-3, 5, 7)};
    field.counts = {11, 8, 17};
    field.whole = whole;
    field.value = [](const std::array<std::uint32_t, 3>& at, double& value) {
      value = 100.0 * at[0] + 10.0 * at[1] - at[2];
      return (at[0] + at[1] + at[2]) % 3 == 0;
    };
    const auto path = dir / "thirds.vdb";
    const auto bytes = writePointField(path, field);
    ASSERT_TRUE(bytes) << bytes.error().text();
    EXPECT_EQ(*bytes, std::filesystem::file_size(path));
    const auto check = [&](const auto& grid) {
      EXPECT_EQ(grid.getName(), "thirds");
      EXPECT_EQ(grid.background(), 0);
      EXPECT_EQ(grid.indexToWorld(openvdb::Vec3d(4, 0, 8)), openvdb::Vec3d(-2, 5, 9));
      std::uint64_t active = 0;
      for (std::uint32_t x = 0; x < field.counts[0]; ++x) {
        for (std::uint32_t y = 0; y < field.counts[1]; ++y) {
          for (std::uint32_t z = 0; z < field.counts[2]; ++z) {
            const openvdb::Coord at = {static_cast<int>(x), static_cast<int>(y),
                                       static_cast<int>(z)};
            double value = 0;
            const bool has = field.value({x, y, z}, value);
            ASSERT_EQ(grid.tree().isValueOn(at), has);
            ASSERT_EQ(grid.tree().getValue(at), has ? value : 0);
            active += has ? 1 : 0;
          }
        }
      }
      EXPECT_EQ(grid.activeVoxelCount(), active);
    };
    if (whole) {
      check(*readGrid<openvdb::Int32Grid>(path));
    } else {
      check(*readGrid<openvdb::FloatGrid>(path));
    }
  }
}

TEST(PointField, OfVoxelsThatOpenVdbTakesForNoneIsRefused) {
  const platform::TestFolder dir;
  PointField field;
  field.name = "fine";
  field.counts = {2, 2, 2};
  field.value = [](const std::array<std::uint32_t, 3>&, double& value) { return value = 1, true; };
  field.lattice = {kFinestVoxel, {-3, 5, 7}};
  ASSERT_TRUE(writePointField(dir / "finest.vdb", field));
  const auto file = VdbFile::open(dir / "finest.vdb");
  ASSERT_TRUE(file) << file.error().text();
  const auto lattice = latticeOf(*(*file)->grids()[0].header, "");
  ASSERT_TRUE(lattice) << lattice.error().text();
  // OpenVDB takes the size from the difference of two points, of coordinates up to 7.
  EXPECT_NEAR(lattice->voxelSize, kFinestVoxel, 1e-15);
  EXPECT_EQ(lattice->origin, field.lattice.origin);

  field.lattice.voxelSize = 0.99 * kFinestVoxel;
  const auto written = writePointField(dir / "finer.vdb", field);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::Unsupported);
  EXPECT_FALSE(std::filesystem::exists(dir / "finer.vdb"));
}

TEST(PointField, OfAMotionSumsToItsHypervolumeAndVisitsVolume) {
  model::TriangleMesh ball = fixtures::icosphere(1, 2);
  for (Point3& vertex : ball.vertices) vertex.x() += 1.5;
  // One and a half turns: places are visited once, twice or not at all.
  const model::ScrewRun run{3, {.angleDegrees = 540, .translation = {0.1, 0.2, 0.4}}, 1};
  const auto motion = model::chainScrews(1, {&run, 1});
  ASSERT_TRUE(motion);
  model::Mesh mesh;
  ASSERT_TRUE(mesh4d::sweep(ball, *motion, {.caps = mesh4d::CapMethod::Cone}, mesh));
  const auto silhouette = measure::silhouetteOf(mesh);
  ASSERT_TRUE(silhouette);

  const platform::TestFolder dir;
  const auto errorsAt = [&](double spacing) {
    auto lattice = measure::SpaceLattice::about(model::boundsOf(silhouette->surface), spacing);
    EXPECT_TRUE(lattice);
    measure::VisitFieldBuilder builder(*lattice);
    EXPECT_TRUE(model::pump(mesh, builder));
    const measure::VisitFields fields = builder.finish();
    const auto write = [&](const char* name, const auto& values) {
      PointField field = fieldOf(*lattice);
      field.whole = std::is_integral_v<std::decay_t<decltype(values[0])>>;
      field.value = [&](const std::array<std::uint32_t, 3>& at, double& value) {
        value = static_cast<double>(values[fields.rowOf(at)]);
        return fields.visits[fields.rowOf(at)] > 0;
      };
      EXPECT_TRUE(writePointField(dir / name, field));
      return dir / name;
    };
    const auto visits = readGrid<openvdb::Int32Grid>(write("visits.vdb", fields.visits));
    const auto dwell = readGrid<openvdb::FloatGrid>(write("dwell.vdb", fields.dwell));
    const auto first = readGrid<openvdb::FloatGrid>(write("first.vdb", fields.first));
    const auto last = readGrid<openvdb::FloatGrid>(write("last.vdb", fields.last));
    double visited = 0;
    double covered = 0;
    for (auto it = visits->cbeginValueOn(); it; ++it) {
      const openvdb::Coord at = it.getCoord();
      const double stay = dwell->tree().getValue(at);
      const double begin = first->tree().getValue(at);
      const double end = last->tree().getValue(at);
      EXPECT_GE(begin, 1);
      EXPECT_LE(begin, end);
      EXPECT_LE(end, 4);
      EXPECT_LE(stay, end - begin + 1e-6);  // they are float32
      visited += it.getValue();
      covered += stay;
    }
    const double cell = spacing * spacing * spacing;
    return std::pair{std::abs(visited * cell / silhouette->visitsVolume - 1),
                     std::abs(covered * cell / silhouette->hypervolume - 1)};
  };
  const auto [visitsCoarse, dwellCoarse] = errorsAt(0.4);
  const auto [visitsFine, dwellFine] = errorsAt(0.1);
  // Errors fall at least in proportion to the spacing.
  EXPECT_LT(visitsCoarse, 0.01);
  EXPECT_LT(visitsFine, visitsCoarse / 4);
  EXPECT_LT(dwellCoarse, 0.01);
  EXPECT_LT(dwellFine, dwellCoarse / 4);
}

}  // namespace
}  // namespace t4d::voxel4d
