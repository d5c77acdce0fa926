#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "t4d/check.h"
#include "t4d/frames.h"
#include "t4d/weave.h"
#include "voxel4d/sample_box.h"
#include "voxel4d/volumes/volume_labels.h"
#include "voxel4d/volumes/volume_samples.h"

/// What volumes do not say, and what the caller says instead: order, times, places, what is
/// outside.
namespace t4d::voxel4d {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class Assumed : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  /// A NIfTI file of one frame: `count` values of the header at a byte are replaced.
  fs::path frame(const std::string& name, int number,
                 const std::map<std::size_t, std::vector<float>>& numbers = {}, int axes = 3) {
    std::string bytes = volumeSamples()["one.nii"].substr(0, 352);
    bytes[40] = static_cast<char>(axes);
    bytes[48] = 1;  // samples along the fourth axis
    for (const auto& [at, values] : numbers) {
      std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(float));
    }
    for (int z = 0; z < 6; ++z) {
      for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 5; ++x) {
          const float value = volumeSample(x, y, z, number);
          bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
        }
      }
    }
    return write(name, bytes);
  }

  /// An array (2, n, n, n) of a type, with `sample(t, x, y, z)`.
  template <class T>
  fs::path npy(const std::string& name, const std::string& type, int n, auto sample) {
    std::string header = fmt::format(
        "{{'descr': '{0}', 'fortran_order': False, 'shape': (2, {1}, {1}, {1}), }}", type, n);
    header.resize(117, ' ');
    std::string bytes = "\x93NUMPY" + std::string("\1\0\x76\0", 4) + header + "\n";
    for (int t = 0; t < 2; ++t) {
      for (int x = 0; x < n; ++x) {
        for (int y = 0; y < n; ++y) {
          for (int z = 0; z < n; ++z) {
            const T value = sample(t, x, y, z);
            bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
          }
        }
      }
    }
    return write(name, bytes);
  }

  std::vector<double> timesOf(const std::vector<fs::path>& files,
                              const VolumeOptions& options = {}) {
    const auto opened = openVolumeFrames(files, options);
    EXPECT_TRUE(opened) << opened.error().text();
    std::vector<double> times;
    for (std::size_t i = 0; opened && i < opened->frames->frameCount(); ++i) {
      times.push_back(opened->frames->frame(i)->time);
    }
    return times;
  }

  std::string refusal(const std::vector<fs::path>& files, const VolumeOptions& options = {}) {
    const auto opened = openVolumeFrames(files, options);
    if (!opened) return folder_.without(opened.error().text());
    for (std::size_t i = 0; i < opened->frames->frameCount(); ++i) {
      if (auto read = opened->frames->frame(i); !read) return folder_.without(read.error().text());
    }
    return "(was accepted)";
  }

  /// The hypervolume, and all of the report, of what is woven.
  measure::MeshReport report(const fs::path& file, const VolumeOptions& options) {
    const auto opened = openVolumeFrames(std::vector{file}, options);
    EXPECT_TRUE(opened) << opened.error().text();
    model::Mesh mesh;
    const auto woven = weave(*opened->frames, {}, mesh);
    EXPECT_TRUE(woven) << woven.error().text();
    return *measure::checkMesh(mesh);
  }

  platform::TestFolder folder_;
};

TEST_F(Assumed, FilesStayInTheOrderGiven) {
  const fs::path before = frame("before.nii", 0);
  const fs::path after = frame("after.nii", 1);
  for (const auto& files : {std::vector{before, after}, std::vector{after, before}}) {
    const auto opened = openVolumeFrames(files, {});
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->frames->placeOf(0).file, files[0].string());
    EXPECT_EQ(opened->frames->placeOf(1).file, files[1].string());
  }
}

TEST_F(Assumed, AFileOfOneFrameSaysNothingOfTime) {
  // pixdim[4] is 0.25 and the unit of time s in both.
  for (const int axes : {3, 4}) {
    const std::vector<fs::path> files = {frame("a.nii", 0, {}, axes), frame("b.nii", 1, {}, axes)};
    const auto opened = openVolumeFrames(files, {});
    ASSERT_TRUE(opened) << opened.error().text();
    EXPECT_TRUE(opened->frames->isOneApart());
    EXPECT_EQ(opened->timeUnit, "");
    EXPECT_EQ(opened->lengthUnit, "mm");
    EXPECT_EQ(timesOf(files), (std::vector<double>{0, 1}));
    EXPECT_EQ(timesOf(files, {.frameTime = 0.5, .startTime = 2}), (std::vector<double>{2, 2.5}));
  }
  // Its four-dimensional file has both.
  const fs::path both = write("both.nii", volumeSamples()["one.nii"]);
  EXPECT_EQ(timesOf({both}), (std::vector<double>{0, 0.25}));
}

TEST_F(Assumed, PlacesThatDifferByRoundingAreOne) {
  const fs::path first = frame("first.nii", 0);
  // The first row of the matrix; the farthest sample is number 4 along x, voxels are 0.5 long.
  const auto moved = [&](float direction, float offset) {
    return refusal({first, frame("moved.nii", 1, {{280, {direction, 0, 0, offset}}})});
  };
  EXPECT_EQ(moved(0.5F, -1), "(was accepted)");
  EXPECT_EQ(moved(0.5F, -1 + 1e-6F), "(was accepted)");
  EXPECT_EQ(moved(0.5F, -1 + 4e-4F), "(was accepted)");  // 0.0008 voxels
  EXPECT_EQ(moved(0.5F + 1e-4F, -1), "(was accepted)");  // 0.0008 voxels at the last sample
  EXPECT_THAT(moved(0.5F, -1 + 6e-4F),
              HasSubstr("a corner of its samples is 0.0012 voxels away from there; up to 0.001"));
  EXPECT_THAT(moved(0.5F, -0.5F), HasSubstr("moved.nii: is placed elsewhere in space than the "
                                            "first frame (first.nii): a corner of its samples is 1 "
                                            "voxels away"));
  EXPECT_THAT(moved(0.6F, -1), HasSubstr("0.8 voxels away"));
  // A place that the caller gives overrides the file's.
  EXPECT_EQ(
      refusal({first, frame("moved.nii", 1, {{280, {0.5F, 0, 0, 7}}})}, {.origin = {{0, 0, 0}}}),
      "(was accepted)");
}

TEST_F(Assumed, TimesOfFramesCanBeGiven) {
  const std::vector<fs::path> files = {frame("a.nii", 0), frame("b.nii", 1), frame("c.nii", 0)};
  EXPECT_EQ(timesOf(files, {.times = {0, 34, 90}}), (std::vector<double>{0, 34, 90}));
  EXPECT_FALSE(openVolumeFrames(files, {.times = {0, 34, 90}})->frames->isOneApart());
  // They are those of all frames, whatever part of them is used.
  VolumeOptions part{.times = {0, 34, 90}};
  part.region = parseRegion(":,:,:,1:").value();
  EXPECT_EQ(timesOf(files, part), (std::vector<double>{34, 90}));
  EXPECT_THAT(refusal(files, {.times = {0, 34}}),
              HasSubstr("a.nii: 2 times for 3 frames: expected one for each"));
  EXPECT_THAT(refusal(files, {.times = {0, 34, 34}}),
              HasSubstr("times do not increase: frame 2 is at 34, the one before at 34"));
  EXPECT_THAT(refusal(files, {.times = {0, 34, INFINITY}}), HasSubstr("frame 2 is inf"));
}

TEST_F(Assumed, InsideIsBelowAValueOnRequest) {
  // A bowl: the distance from the middle; below 3 it is a ball, and so is -distance above -3.
  const auto distance = [](int, int x, int y, int z) {
    return static_cast<float>(std::hypot(x - 4, y - 4, z - 4));
  };
  const fs::path bowl = npy<float>("bowl.npy", "<f4", 9, distance);
  const fs::path hill =
      npy<float>("hill.npy", "<f4", 9, [&](auto... at) { return -distance(at...); });
  const measure::MeshReport below = report(bowl, {.iso = 3, .below = true});
  const measure::MeshReport above = report(hill, {.iso = -3});
  EXPECT_EQ(below.hypervolume, above.hypervolume);
  EXPECT_GT(below.hypervolume, 90);
  EXPECT_THAT(refusal({bowl}, {.iso = -1, .below = true}),
              HasSubstr("no sample of any frame is below the iso value -1"));
}

TEST_F(Assumed, SamplesWithoutDataLieOutside) {
  // A cube of 3 x 3 x 3 samples in the middle, one corner of which has no data.
  const auto sample = [](float none) {
    return [none](int, int x, int y, int z) {
      const auto isIn = [](int i) { return i >= 2 && i <= 4; };
      if (x == 4 && y == 4 && z == 4) return none;
      return isIn(x) && isIn(y) && isIn(z) ? 1.0F : 0.0F;
    };
  };
  const fs::path cut = npy<float>("cut.npy", "<f4", 7, sample(0));
  const fs::path nan = npy<float>("nan.npy", "<f4", 7, sample(NAN));
  const fs::path high = npy<float>("high.npy", "<f4", 7, sample(9999.9F));
  const double expected = report(cut, {.iso = 0.5}).hypervolume;
  EXPECT_THAT(refusal({nan}, {.iso = 0.5}), HasSubstr("is not finite"));
  EXPECT_NEAR(report(nan, {.iso = 0.5, .outside = NAN}).hypervolume, expected, 1e-6);
  EXPECT_GT(report(high, {.iso = 0.5}).hypervolume, expected + 0.5);
  EXPECT_NEAR(report(high, {.iso = 0.5, .outside = 9999.9}).hypervolume, expected, 1e-6);
  // Low values are inside, where samples without data would be inside, too.
  const fs::path padded = npy<float>("padded.npy", "<f4", 7, [&](auto... at) {
    const float value = sample(0)(at...);
    return value > 0 ? -1.0F : -2000.0F;
  });
  EXPECT_NEAR(report(padded, {.iso = 0, .below = true, .outside = -2000}).hypervolume, expected,
              1e-6);
  EXPECT_THAT(refusal({cut}, {.outside = 0, .label = 1}),
              HasSubstr("no value for it can be given"));
}

TEST_F(Assumed, AllLabelsAreFound) {
  const auto label = [](int t, int x, int y, int) {
    return static_cast<std::int16_t>(x == 2 && y == 3   ? -7
                                     : x == 4           ? 300
                                     : t == 1 && x == 0 ? 2
                                                        : 0);
  };
  const fs::path labels = npy<std::int16_t>("labels.npy", "<i2", 9, label);
  using Labels = std::vector<std::int64_t>;
  EXPECT_EQ(labelsOf(std::vector{labels}, {}).value(), (Labels{-7, 2, 300}));
  VolumeOptions part;
  part.region = parseRegion("3:,:,:").value();
  EXPECT_EQ(labelsOf(std::vector{labels}, part).value(), (Labels{300}));
  const auto faultOf = [&](const fs::path& file) {
    const auto found = labelsOf(std::vector{file}, {});
    return found ? "(was accepted)" : folder_.without(found.error().text());
  };
  EXPECT_THAT(faultOf(npy<float>("half.npy", "<f4", 5, [](auto...) { return 0.5F; })),
              HasSubstr("has the sample 0.5 at (0, 0, 0); labels are whole numbers"));
  EXPECT_THAT(faultOf(npy<std::int16_t>("none.npy", "<i2", 5, [](auto...) { return 0; })),
              HasSubstr("none.npy: has no label: all samples of all frames are 0"));
  const auto all = [](int, int x, int y, int z) {
    return static_cast<std::int16_t>(100 * x + 10 * y + z + 1);
  };
  EXPECT_EQ(labelsOf(std::vector{npy<std::int16_t>("all.npy", "<i2", 10, all)}, {})->size(), 1000U);
  EXPECT_THAT(faultOf(npy<std::int16_t>("more.npy", "<i2", 11,
                                        [](int, int x, int y, int z) {
                                          return static_cast<std::int16_t>(121 * x + 11 * y + z);
                                        })),
              HasSubstr("has more than 1000 different samples, so they are not labels"));
}

TEST_F(Assumed, WhatIsAssumedIsSaid) {
  const fs::path array = npy<float>("a.npy", "<f4", 5, [](auto...) { return -1.0F; });
  const auto opened = [&](const fs::path& file, const VolumeOptions& options = {}) {
    auto frames = openVolumeFrames(std::vector{file}, options);
    EXPECT_TRUE(frames) << frames.error().text();
    return std::move(*frames);
  };
  EXPECT_EQ(opened(array).unsized, "xyz");
  EXPECT_EQ(opened(array).assumedAxes, "txyz");
  EXPECT_EQ(opened(array, {.spacing = {{1, 1, 1}}}).unsized, "");
  EXPECT_EQ(opened(array, {.axes = "txyz"}).assumedAxes, "");
  for (const auto& [name, bytes] : volumeSamples()) {
    if (!name.ends_with(".nii") && !name.ends_with("w.nrrd")) continue;
    const auto said = opened(write(name, bytes));
    EXPECT_EQ(said.unsized + said.assumedAxes, "") << name;
  }
  std::string bare = volumeSamples()["raw.nrrd"];
  const auto directions = bare.find("space directions");
  bare.erase(directions, bare.find('\n', directions) + 1 - directions);
  EXPECT_EQ(opened(write("bare.nrrd", bare)).unsized, "xyz");
  bare.replace(bare.find("nan nan nan"), 11, "0.5 0.5 0.5");
  EXPECT_EQ(opened(write("spaced.nrrd", bare)).unsized, "");
  const auto line = opened(write("line.raw", volumeSamples()["line.raw"]));
  EXPECT_EQ(line.unsized, "xyz");
  EXPECT_EQ(line.assumedAxes, "");  // the format says them
}

}  // namespace
}  // namespace t4d::voxel4d
