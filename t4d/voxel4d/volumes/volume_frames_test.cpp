#include "t4d/voxel4d/volumes/volume_frames.h"

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "t4d/measure/mesh_check.h"
#include "t4d/model/transformed.h"
#include "t4d/voxel4d/array_frames.h"
#include "t4d/voxel4d/test_files.h"
#include "t4d/voxel4d/volumes/volume_samples.h"
#include "t4d/voxel4d/weave.h"

namespace t4d::voxel4d {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

void writeFile(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

bool isDataOnly(const std::string& name) {
  return name.ends_with(".img") || (name.ends_with(".raw") && name != "line.raw");
}

/// For formats that do not say where samples are.
VolumeOptions placed() {
  return {.frameTime = 0.25, .spacing = {{0.5, 0.5, 0.5}}, .origin = {{-1, 2, 0.25}}};
}

Result<model::Mesh> wovenOf(const std::vector<fs::path>& files, const VolumeOptions& options) {
  auto opened = openVolumeFrames(files, options);
  if (!opened) return pass(opened.error());
  model::Mesh mesh;
  model::Transformed toSpace(mesh, {opened->toSpace.value_or(model::Affine3x4::Identity())});
  auto report =
      opened->toSpace ? weave(*opened->frames, {}, toSpace) : weave(*opened->frames, {}, mesh);
  if (!report) return pass(report.error());
  return mesh;
}

std::string faultOf(const std::vector<fs::path>& files, const VolumeOptions& options) {
  const auto mesh = wovenOf(files, options);
  return mesh ? "" : mesh.error().text();
}

model::Mesh expectedMesh() {
  std::vector<std::vector<float>> memory(2);
  for (int t = 0; t < 2; ++t) {
    for (int x = 0; x < 5; ++x) {
      for (int y = 0; y < 4; ++y) {
        for (int z = 0; z < 6; ++z) memory[t].push_back(volumeSample(x, y, z, t));
      }
    }
  }
  const std::vector<ArrayFrame<float>> frames = {{0, memory[0]}, {0.25, memory[1]}};
  auto source = arrayFrames<float>(frames, {{5, 4, 6}, {0.5, {-1, 2, 0.25}}});
  model::Mesh mesh;
  EXPECT_TRUE(source && weave(**source, {}, mesh));
  return mesh;
}

void expectSameMesh(const model::Mesh& a, const model::Mesh& b) {
  ASSERT_EQ(a.slabCount(), b.slabCount());
  for (std::size_t i = 0; i < a.slabCount(); ++i) {
    EXPECT_EQ(a.slabs()[i].vertices, b.slabs()[i].vertices);
    EXPECT_EQ(*a.slabs()[i].connectivity, *b.slabs()[i].connectivity);
  }
}

/// The samples of the formats in a folder.
class VolumeFiles : public testing::Test {
 protected:
  void SetUp() override {
    for (const auto& [name, bytes] : files_) writeFile(folder_ / name, bytes);
  }
  std::map<std::string, std::string> files_ = volumeSamples();
  TestFolder folder_;
};

TEST_F(VolumeFiles, TheSameFieldInEveryFormatIsTheSameMesh) {
  const model::Mesh expected = expectedMesh();
  std::set<std::string> extensions;
  for (const auto& [name, bytes] : files_) {
    if (isDataOnly(name)) continue;
    SCOPED_TRACE(name);
    VolumeOptions options = placed();
    if (name == "fortran.npy") options.axes = "txyz";
    const auto mesh = wovenOf({folder_ / name}, options);
    ASSERT_TRUE(mesh) << mesh.error().text();
    expectSameMesh(*mesh, expected);
    for (const VolumeFormat& format : volumeFormats()) {
      if (name.ends_with(format.extension)) extensions.emplace(format.extension);
    }
  }
  EXPECT_EQ(extensions.size(), volumeFormats().size()) << "a format has no sample";
  VolumeOptions series = placed();
  series.raw = "float32 5 4 6 little";
  const auto mesh = wovenOf({folder_ / "f02.raw", folder_ / "f01.raw"}, series);
  ASSERT_TRUE(mesh) << mesh.error().text();
  expectSameMesh(*mesh, expected);
}

TEST_F(VolumeFiles, PlaceTimeAndUnitsAreThoseOfTheFile) {
  const model::Mesh expected = expectedMesh();
  const std::map<std::string, std::string> timeUnits = {{"raw.nrrd", ""},
                                                        {"pattern.nhdr", ""},
                                                        {"one_big.nii.gz", "s"},
                                                        {"two.nii", "s"},
                                                        {"pair.hdr", "s"}};
  for (const auto& [name, timeUnit] : timeUnits) {
    SCOPED_TRACE(name);
    const auto mesh = wovenOf({folder_ / name}, {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    expectSameMesh(*mesh, expected);
    const auto opened = openVolumeFrames(std::vector{folder_ / name}, {});
    EXPECT_EQ(opened->lengthUnit, "mm");
    EXPECT_EQ(opened->timeUnit, timeUnit);
  }
}

/// Voxels that are no cubes, turned, skewed and mirrored: the mesh is the image of that with voxels
/// of 1, outward, so its hypervolume is that of the other by the determinant.
TEST_F(VolumeFiles, VoxelsNeedNotBeCubes) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto cubes = wovenOf({folder_ / "c.npy"}, {.frameTime = 0.25});
  ASSERT_TRUE(cubes) << cubes.error().text();
  const double unit = measure::checkMesh(*cubes)->hypervolume;
  for (int trial = 0; trial < 12; ++trial) {
    SCOPED_TRACE(trial);
    Eigen::Matrix3d axes;
    for (double& entry : axes.reshaped()) entry = normal(random);
    std::string header = files_["raw.nrrd"];
    const auto begin = header.find("space directions");
    const auto end = header.find('\n', begin);
    header.replace(begin, end - begin,
                   fmt::format("space directions: ({},{},{}) ({},{},{}) ({},{},{}) none",
                               axes(0, 0), axes(1, 0), axes(2, 0), axes(0, 1), axes(1, 1),
                               axes(2, 1), axes(0, 2), axes(1, 2), axes(2, 2)));
    writeFile(folder_ / "skewed.nrrd", header);
    const auto mesh = wovenOf({folder_ / "skewed.nrrd"}, {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    const auto report = measure::checkMesh(*mesh);
    ASSERT_TRUE(report && report->closed && report->oriented);
    const double expected = unit * std::abs(axes.determinant());
    EXPECT_NEAR(report->hypervolume, expected, 1e-11 * expected);
  }
  // Other lengths leave the directions of a file: here x is mirrored.
  std::string mirrored = files_["raw.nrrd"];
  mirrored.replace(mirrored.find("(0.5,0,0)"), 9, "(-.5,0,0)");
  writeFile(folder_ / "mirrored.nrrd", mirrored);
  const auto plain = wovenOf({folder_ / "mirrored.nrrd"}, {});
  const auto longer = wovenOf({folder_ / "mirrored.nrrd"}, {.spacing = {{1, 0.5, 0.5}}});
  ASSERT_TRUE(plain && longer);
  EXPECT_NEAR(measure::checkMesh(*longer)->bounds.min[0] + 1,
              2 * (measure::checkMesh(*plain)->bounds.min[0] + 1), 1e-12);
  const auto flat = wovenOf({folder_ / "c.npy"}, {.frameTime = 0.25, .spacing = {{1, 2, 3}}});
  ASSERT_TRUE(flat);
  EXPECT_NEAR(measure::checkMesh(*flat)->hypervolume, 6 * unit, 1e-11 * unit);
}

TEST_F(VolumeFiles, IsoValuesScalesAndLabels) {
  // Bytes: 200 inside, 100 outside; scaled by 0.01 to 2 and 1.
  std::string bytes;
  std::string labels;
  for (int t = 0; t < 2; ++t) {
    for (int z = 0; z < 6; ++z) {
      for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 5; ++x) {
          const bool inside = volumeSample(x, y, z, t) < 0;
          bytes += static_cast<char>(inside ? 200 : 100);
          labels += static_cast<char>(inside ? 3 : x % 3);
        }
      }
    }
  }
  std::string header = files_["one.nii"].substr(0, 352);
  header[70] = 2;
  writeFile(folder_ / "bytes.nii", header + bytes);
  writeFile(folder_ / "labels.nii", header + labels);
  const std::string scale("\x0A\xD7\x23\x3C\0\0\0\0", 8);  // 0.01 and 0 as float32
  header.replace(112, 8, scale);
  writeFile(folder_ / "scaled.nii", header + bytes);

  EXPECT_THAT(faultOf({folder_ / "bytes.nii"}, {}),
              HasSubstr("an iso value or a label must be given"));
  const auto byIso = wovenOf({folder_ / "bytes.nii"}, {.iso = 150});
  const auto byScale = wovenOf({folder_ / "scaled.nii"}, {.iso = 1.5});
  const auto byLabel = wovenOf({folder_ / "labels.nii"}, {.label = 3});
  const auto other = wovenOf({folder_ / "labels.nii"}, {.label = 1});
  ASSERT_TRUE(byIso && byScale && byLabel && other);
  const model::Mesh expected = expectedMesh();
  for (std::size_t i = 0; i < expected.slabCount(); ++i) {
    for (const auto* mesh : {&*byIso, &*byScale, &*byLabel}) {
      EXPECT_EQ(*mesh->slabs()[i].connectivity, *expected.slabs()[i].connectivity);
    }
    // 150 is half way between 100 and 200, where the surface of labels is.
    EXPECT_EQ(byIso->slabs()[i].vertices, byLabel->slabs()[i].vertices);
  }
  EXPECT_TRUE(measure::checkMesh(*other)->closed);
  EXPECT_THAT(faultOf({folder_ / "labels.nii"}, {.label = 9}),
              HasSubstr("no sample of any frame is 9"));
  EXPECT_THAT(faultOf({folder_ / "scaled.nii"}, {.label = 3}), HasSubstr("are not labels"));
}

TEST_F(VolumeFiles, SayWhatIsWrong) {
  const auto changed = [&](const std::string& name, const std::string& from,
                           const std::string& to) {
    std::string bytes = files_[name];
    const auto at = bytes.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    bytes.replace(at, from.size(), to);
    const std::string changedName = "x" + name;
    writeFile(folder_ / changedName, bytes);
    return folder_.without(faultOf({folder_ / changedName}, {}));
  };
  EXPECT_EQ(changed("raw.nrrd", "type: float", "type: block"),
            "xraw.nrrd: its field 'type: block' is not supported; integers, float and double are");
  for (const char* field : {"type", "dimension", "sizes", "encoding", "endian"}) {
    EXPECT_EQ(changed("raw.nrrd", std::string(field) + ": ", "other: "),
              "xraw.nrrd: lacks the field '" + std::string(field) + "', which is required");
  }
  writeFile(folder_ / "empty.nrrd", "");
  EXPECT_THAT(faultOf({folder_ / "empty.nrrd"}, {}), HasSubstr("empty.nrrd: is empty"));
  EXPECT_THAT(changed("raw.nrrd", "left-posterior-superior", "RAST"),
              HasSubstr("its field 'space: RAST' has four dimensions"));
  EXPECT_THAT(changed("raw.nrrd", "sizes: 5 4 6 2", "sizes: 5 4 6 3"),
              HasSubstr("is cut off or damaged"));
  EXPECT_THAT(changed("raw.nrrd", "sizes: 5 4 6 2", "sizes: 5 4 3 2"),
              HasSubstr("bytes more than the samples that its header announces"));
  EXPECT_THAT(changed("gzip.nrrd", "sizes: 5 4 6 2", "sizes: 5 4 6 3"),
              HasSubstr("is cut off: it unpacks to 960 bytes, but its header announces 1440"));
  EXPECT_THAT(changed("gzip.nrrd", "sizes: 5 4 6 2", "sizes: 5 4 3 2"),
              HasSubstr(": unpacks to 960 bytes, but its header announces 480"));
  EXPECT_THAT(changed("gzip.nrrd", "sizes: 5 4 6 2", "sizes: 4000 4000 4000 2"),
              HasSubstr("cannot hold"));
  EXPECT_THAT(changed("raw.nrrd", "sizes: 5 4 6 2", "sizes: 4294967295 4294967295 4294967295 2"),
              HasSubstr("announces"));
  EXPECT_THAT(changed("raw.nrrd", "0.5) none", "0) none"), HasSubstr("voxels without volume"));
  EXPECT_THAT(changed("raw.nrrd", "nan 0.25", "nan nan"),
              HasSubstr("does not say how long it is from frame to frame"));
  EXPECT_THAT(changed("raw.nrrd", "space space space time", "RGB-color space space space"),
              HasSubstr("single numbers"));
  EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", "../f%02d.raw 1 2 1"),
              HasSubstr("in the same folder or below"));
  EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", "f%02d.raw 1 3 1"),
              HasSubstr("names 3 files"));
  EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", "f%02d.raw 1 999999999999 1"),
              HasSubstr("is not a name with %d"));
  EXPECT_THAT(changed("pattern.nhdr", "sizes: 5 4 6 2", "sizes: 5 4 7 2"),
              HasSubstr("f01.raw: is cut off or damaged: 560 bytes of samples are announced, which "
                        "480 bytes cannot hold (the samples of xpattern.nhdr)"));
  EXPECT_THAT(changed("c.npy", "'<f4'", "'<c8'"), HasSubstr("has samples of type '<c8"));
  EXPECT_THAT(changed("c.npy", "(2, 5, 4, 6)", "(2, 5, 24  )"), HasSubstr("has one frame only"));
  EXPECT_THAT(changed("line.raw", "raw float32", "raw float16"),
              HasSubstr("has the type 'float16'"));
  const fs::path line = folder_ / "line.raw";
  EXPECT_EQ(faultOf({line}, {.frameTime = 1, .raw = "float32 5 4 6 2 big"}), "");
  EXPECT_THAT(faultOf({line}, {.frameTime = 1, .raw = "float32 5 4 6 2"}),
              HasSubstr("begins with the line 'raw float32 5 4 6 2 big', which contradicts"));
  EXPECT_THAT(changed("text.nrrd", "encoding: text", "encoding: text\nbyte skip: 4"),
              HasSubstr("is not a number of bytes to skip"));
  EXPECT_THAT(faultOf({folder_ / "f01.raw"}, {}),
              HasSubstr("does not begin with a line that says what it holds"));
  EXPECT_THAT(faultOf({folder_ / "one.nii", folder_ / "two.nii"}, {}),
              HasSubstr("holds 2 frames; where there are several files"));

  std::string notFinite = files_["one.nii"];
  notFinite.replace(352 + 4 * 7, 4, std::string("\0\0\xC0\x7F", 4));
  writeFile(folder_ / "nan.nii", notFinite);
  EXPECT_THAT(faultOf({folder_ / "nan.nii"}, {}),
              HasSubstr("the sample (x 2, y 1, z 0) of frame 0 (counted from 0) is not finite"));
}

/// Every file cut at every byte, and with every byte changed, is refused or read; what is cut
/// within its samples is always refused.
TEST_F(VolumeFiles, DamageIsRefusedOrHarmless) {
  for (const auto& [name, bytes] : files_) {
    if (isDataOnly(name)) continue;
    SCOPED_TRACE(name);
    const std::string damagedName = "damaged" + name;
    const fs::path path = folder_ / damagedName;
    const bool hasSamples = !name.ends_with(".nhdr") && name != "pair.hdr";
    const std::size_t step = 1 + bytes.size() / 60;
    for (std::size_t size = 0; size < bytes.size(); size += step) {
      writeFile(path, bytes.substr(0, size));
      const bool refused = !faultOf({path}, placed()).empty();
      EXPECT_TRUE(refused || !hasSamples || name == "text.nrrd") << "cut at " << size;
    }
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      std::string changed = bytes;
      changed[at] = static_cast<char>(changed[at] ^ (at % 2 == 0 ? 0x01 : 0x80));
      writeFile(path, changed);
      (void)faultOf({path}, placed());
    }
  }
}

}  // namespace
}  // namespace t4d::voxel4d
