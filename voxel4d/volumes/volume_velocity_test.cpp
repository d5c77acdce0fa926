#include "voxel4d/volumes/volume_velocity.h"

#include <cmath>
#include <fstream>
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "voxel4d/advected_frames.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;
using model::Point3;

constexpr int kSize = 32;

/// A file of floats for two frames along axes t, z, y, x.
class VolumeVelocities : public testing::Test {
 protected:
  using ValueAt = std::function<double(const Point3& point, int frame)>;

  template <class Number = float>
  fs::path file(const std::string& name, const ValueAt& valueAt, int size = kSize) const {
    std::ofstream out(folder_ / name, std::ios::binary);
    std::string header =
        fmt::format("{{'descr': '<{0}{1}', 'fortran_order': False, 'shape': (2, {2}, {2}, {2}), }}",
                    std::is_integral_v<Number> ? 'i' : 'f', sizeof(Number), size);
    header.resize(117, ' ');
    out << std::string("\x93NUMPY\1\0\x76\0", 10) << header << '\n';
    for (int frame = 0; frame < 2; ++frame) {
      for (int z = 0; z < size; ++z) {
        for (int y = 0; y < size; ++y) {
          for (int x = 0; x < size; ++x) {
            const auto value = static_cast<Number>(valueAt(Point3(x, y, z), frame));
            out.write(reinterpret_cast<const char*>(&value), sizeof value);
          }
        }
      }
    }
    return folder_ / name;
  }

  /// A ball of radius 5 that moves by 8 samples along x.
  fs::path ball() const {
    return file("ball.npy", [](const Point3& point, int frame) {
      return (point - Point3(11.3 + 8 * frame, 15.2, 15.9)).norm() - 5;
    });
  }
  std::array<fs::path, 3> velocities(const Eigen::Vector3d& velocity) const {
    std::array<fs::path, 3> files;
    for (int axis = 0; axis < 3; ++axis) {
      files[axis] =
          file(fmt::format("v{}.npy", axis), [&](const Point3&, int) { return velocity[axis]; });
    }
    return files;
  }

  static VolumeOptions options() {
    VolumeOptions options;
    options.axes = "tzyx";
    options.frameTime = 0.5;
    options.spacing = {2, 2, 2};
    return options;
  }

  Error errorOf(std::span<const fs::path> files, const VolumeOptions& how = options()) const {
    const fs::path input = ball();
    const auto frames = openVolumeFrames({&input, 1}, how);
    EXPECT_TRUE(frames);
    auto velocity = openVolumeVelocity(files, how, *frames);
    if (!velocity) return velocity.error();
    const auto field = (*velocity)->field(0);
    return field ? Error{} : field.error();
  }

  platform::TestFolder folder_;
};

TEST_F(VolumeVelocities, AreThoseOfSpaceInLatticePoints) {
  const auto files = velocities({32, 6, 0});
  const fs::path input = ball();
  for (const auto& spacing : {std::array<double, 3>{2, 2, 2}, std::array<double, 3>{2, 3, 4}}) {
    VolumeOptions how = options();
    how.spacing = spacing;
    const auto frames = openVolumeFrames({&input, 1}, how);
    ASSERT_TRUE(frames);
    const auto source = openVolumeVelocity(files, how, *frames);
    ASSERT_TRUE(source) << source.error().text();
    const auto field = (*source)->field(0);
    ASSERT_TRUE(field);
    const auto velocity = field->at({3, 4, 5});
    ASSERT_TRUE(velocity);
    EXPECT_NEAR((*velocity)[0], 32 / spacing[0], 1e-12);
    EXPECT_NEAR((*velocity)[1], 6 / spacing[1], 1e-12);
    EXPECT_FALSE(field->at({kSize, 4, 5}));
    EXPECT_FALSE(field->at({-1, 4, 5}));
  }
}

TEST_F(VolumeVelocities, CarryABallToTheMiddle) {
  const fs::path input = ball();
  auto frames = openVolumeFrames({&input, 1}, options());
  ASSERT_TRUE(frames);
  // 8 samples, each 2 long, in half a time unit.
  auto source = openVolumeVelocity(velocities({32, 0, 0}), options(), *frames);
  ASSERT_TRUE(source);
  const auto carried = advectedFrames(std::move(frames->frames), std::move(*source), 2);
  ASSERT_EQ(carried->frameCount(), 3);
  std::array<double, 3> inside{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto frame = carried->frame(i);
    ASSERT_TRUE(frame) << frame.error().text();
    inside[i] = static_cast<double>(countInside(*frame));
  }
  EXPECT_GT(inside[0], 400);
  EXPECT_NEAR(inside[1], inside[0], 0.01 * inside[0]);
}

TEST_F(VolumeVelocities, OfAFrameAtRestCarryNothing) {
  const fs::path input = ball();
  auto frames = openVolumeFrames({&input, 1}, options());
  ASSERT_TRUE(frames);
  auto source = openVolumeVelocity(velocities({0, 0, 0}), options(), *frames);
  ASSERT_TRUE(source);
  const auto carried = advectedFrames(std::move(frames->frames), std::move(*source), 2);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(carried->frame(i));
}

TEST_F(VolumeVelocities, OfTheOtherSignLeaveANotice) {
  const fs::path input = ball();
  auto frames = openVolumeFrames({&input, 1}, options());
  ASSERT_TRUE(frames);
  auto source = openVolumeVelocity(velocities({-32, 0, 0}), options(), *frames);
  ASSERT_TRUE(source);
  const auto carried = advectedFrames(std::move(frames->frames), std::move(*source), 2);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(carried->frame(i));
  EXPECT_NE(carried->notice().find("in 1 of the frames in between"), std::string::npos);
}

TEST_F(VolumeVelocities, MayBeNumbersOfAnySignAndType) {
  std::array<fs::path, 3> files = velocities({-4, -4, -4});
  files[1] = file<std::int16_t>("whole.npy", [](const Point3&, int) { return 3; });
  EXPECT_EQ(errorOf(files).text(), "");
}

TEST_F(VolumeVelocities, AreRefusedWithTheirFile) {
  std::array<fs::path, 3> files = velocities({4, 4, 4});
  for (const std::size_t count : {1, 2}) {
    EXPECT_NE(errorOf({files.data(), count}).message.find("expected three"), std::string::npos);
  }
  files[2] = file(
      "small.npy", [](const Point3&, int) { return 1; }, kSize / 2);
  const Error small = errorOf(files);
  EXPECT_NE(small.message.find("16 x 16 x 16 samples in 2 frames"), std::string::npos);
  EXPECT_NE(small.where.text().find("small.npy"), std::string::npos);
  files[2] = file("nan.npy", [](const Point3& point, int) {
    return point == Point3(1, 2, 3) ? std::nan("") : 1;
  });
  EXPECT_NE(errorOf(files).message.find("x 1, y 2, z 3"), std::string::npos)
      << errorOf(files).text();
}

}  // namespace
}  // namespace t4d::voxel4d
