#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "platform/test_folder.h"
#include "t4d/check.h"
#include "t4d/frames.h"
#include "t4d/mesh.h"
#include "t4d/weave.h"
#include "voxel4d/frame_formats.h"
#include "voxel4d/volumes/volume_samples.h"

namespace t4d::voxel4d {
namespace {

using namespace std::string_literals;
using testing::HasSubstr;
namespace fs = std::filesystem;

void writeFile(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

bool isDataOnly(const std::string& name) {
  return name.ends_with(".img") || (name.ends_with(".raw") && name != "line.raw");
}

/// Options for formats that do not say where samples are.
VolumeOptions placed() {
  return {.frameTime = 0.25, .spacing = {{0.5, 0.5, 0.5}}, .origin = {{-1, 2, 0.25}}};
}

Result<model::Mesh> wovenOf(const std::vector<fs::path>& files, const VolumeOptions& options) {
  auto opened = openVolumeFrames(files, options);
  if (!opened) return opened.error();
  model::Mesh mesh;
  model::Transformed toSpace(mesh, {opened->toSpace.value_or(model::Affine3x4::Identity())});
  auto report =
      opened->toSpace ? weave(*opened->frames, {}, toSpace) : weave(*opened->frames, {}, mesh);
  if (!report) return report.error();
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
  platform::TestFolder folder_;
};

TEST_F(VolumeFiles, FramesWhoseTimesAreInTheMiddleAreSortedWhateverTheirSize) {
  // A slice z of all frames, two of 5 or of 8.5 MB each, is half of what is sorted in memory or
  // does not fit into it.
  const auto isInside = [](int x, int y, int z, int t) {
    return std::abs(x - 1000 - 2 * t) < 3 && std::abs(y - 2000) < 5 && z + t < 3;
  };
  constexpr int kDepth = 3;
  const auto write = [&](const std::string& name, int side, bool timeLast) {
    std::ofstream file(folder_ / name, std::ios::binary);
    file << "NRRD0004\ntype: uint8\ndimension: 4\nencoding: raw\nsizes: " << side << ' ' << side
         << (timeLast ? " 3 2" : " 2 3") << "\nkinds: domain domain "
         << (timeLast ? "domain time" : "time domain") << "\n\n";
    std::string plane(static_cast<std::size_t>(side) * side, '\0');
    for (int i = 0; i < 2 * kDepth; ++i) {
      const int t = timeLast ? i / kDepth : i % 2;
      const int z = timeLast ? i % kDepth : i / 2;
      std::ranges::fill(plane, '\0');
      for (int y = 1990; y < 2010; ++y) {
        for (int x = 990; x < 1010; ++x) {
          if (isInside(x, y, z, t)) plane[static_cast<std::size_t>(side) * y + x] = 9;
        }
      }
      file << plane;
    }
  };
  for (const int side : {2200, 2900}) {
    write("last.nrrd", side, true);
    write("middle.nrrd", side, false);
    const VolumeOptions options{.iso = 4, .frameTime = 1};
    const auto last = wovenOf({folder_ / "last.nrrd"}, options);
    const auto middle = wovenOf({folder_ / "middle.nrrd"}, options);
    ASSERT_TRUE(last) << last.error().text();
    ASSERT_TRUE(middle) << middle.error().text();
    const auto one = measure::checkMesh(*last);
    const auto other = measure::checkMesh(*middle);
    ASSERT_TRUE(one && other);
    EXPECT_GT(one->hypervolume, 50);
    EXPECT_EQ(one->hypervolume, other->hypervolume);
    EXPECT_EQ(one->boundaryVolume, other->boundaryVolume);
    EXPECT_EQ(one->bounds.min, other->bounds.min);
    EXPECT_EQ(one->bounds.max, other->bounds.max);
  }
}

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
    for (const std::string_view extension : volumeExtensions()) {
      if (name.ends_with(extension)) extensions.emplace(extension);
    }
  }
  EXPECT_EQ(extensions.size(), volumeExtensions().size()) << "a format has no sample";
  VolumeOptions series = placed();
  series.raw = "float32 5 4 6 little";
  const auto mesh = wovenOf({folder_ / "f01.raw", folder_ / "f02.raw"}, series);
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
  // Bytes: 200 inside, 100 outside; scaled by 0.01 and moved by 0.5 to 2.5 and 1.5.
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
  const std::string scale("\x0A\xD7\x23\x3C\0\0\0\x3F", 8);  // 0.01 and 0.5 as float32
  header.replace(112, 8, scale);
  writeFile(folder_ / "scaled.nii", header + bytes);

  EXPECT_THAT(faultOf({folder_ / "bytes.nii"}, {}),
              HasSubstr("an iso value or a label must be given"));
  const auto byIso = wovenOf({folder_ / "bytes.nii"}, {.iso = 150});
  const auto byScale = wovenOf({folder_ / "scaled.nii"}, {.iso = 2.25});
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
              HasSubstr("is not a vector (x,y,z,t), or none, for each of 4 axes"));
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
  EXPECT_THAT(changed("raw.nrrd", "space space space time", "RGB-color space space space"),
              HasSubstr("single numbers"));
  EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", "../f%02d.raw 1 2 1"),
              HasSubstr("in the same folder or below"));
  EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", "f%02d.raw 1 3 1"),
              HasSubstr("names 3 files"));
  EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", "f%02d.raw 1 999999999999 1"),
              HasSubstr("is not a name with %d"));
  for (const char* name :
       {"f%021d.raw 1 2 1", "f%02d.raw x 2 1", "f%02d.raw 1 2 0", "f%xd.raw 1 2 1"}) {
    EXPECT_THAT(changed("pattern.nhdr", "f%02d.raw 1 2 1", name),
                HasSubstr("is not a name with %d"))
        << name;
  }
  EXPECT_THAT(changed("pattern.nhdr", "sizes: 5 4 6 2", "sizes: 5 4 7 2"),
              HasSubstr("f01.raw: is cut off or damaged: 560 bytes of samples are announced, which "
                        "480 bytes cannot hold (the samples of xpattern.nhdr)"));
  EXPECT_THAT(changed("c.npy", "'<f4'", "'<c8'"), HasSubstr("has samples of type '<c8"));
  EXPECT_THAT(changed("c.npy", "(2, 5, 4, 6)", "(2, 5, 24  )"), HasSubstr("has one frame only"));
  EXPECT_THAT(changed("line.raw", "raw float32", "raw float16"),
              HasSubstr("has the type 'float16'"));
  EXPECT_THAT(changed("line.raw", "5 4 6 2", "5 4 x 2"), HasSubstr("has the size 'x'"));
  const fs::path line = folder_ / "line.raw";
  EXPECT_EQ(faultOf({line}, {.frameTime = 1, .raw = "float32 5 4 6 2 big"}), "");
  EXPECT_THAT(faultOf({line}, {.frameTime = 1, .raw = "float32 5 4 6 2"}),
              HasSubstr("begins with the line 'raw float32 5 4 6 2 big', which contradicts"));
  for (const char* skip : {"-2", "-1.5", "4x"}) {
    EXPECT_THAT(changed("raw.nrrd", "encoding: raw", "encoding: raw\nbyte skip: "s + skip),
                HasSubstr("is not a number of bytes to skip"));
  }
  EXPECT_THAT(faultOf({folder_ / "f01.raw"}, {}),
              HasSubstr("does not begin with a line that says what it holds"));
  // A line break among samples ends no line, and a word alone begins none.
  for (const std::string& bytes : {"\1\2\n"s + files_["f01.raw"], "raw " + std::string(300, 'x')}) {
    writeFile(folder_ / "samples.raw", bytes);
    EXPECT_THAT(faultOf({folder_ / "samples.raw"}, {}),
                HasSubstr("does not begin with a line that says what it holds"));
  }
  for (const char axes : {'\2', '\x08'}) {
    std::string bytes = files_["one.nii"];
    bytes[40] = axes;
    writeFile(folder_ / "axes.nii", bytes);
    EXPECT_THAT(faultOf({folder_ / "axes.nii"}, {}),
                HasSubstr(fmt::format("has {} axes; expected three or four", int{axes})));
  }
  EXPECT_THAT(faultOf({folder_ / "one.nii", folder_ / "two.nii"}, {}),
              HasSubstr("holds 2 frames; where there are several files"));

  std::string notFinite = files_["one.nii"];
  notFinite.replace(352 + 4 * 7, 4, std::string("\0\0\xC0\x7F", 4));
  writeFile(folder_ / "nan.nii", notFinite);
  EXPECT_THAT(faultOf({folder_ / "nan.nii"}, {}),
              HasSubstr("the sample (x 2, y 1, z 0) of frame 0 (counted from 0) is not finite"));
}

TEST_F(VolumeFiles, WithoutATimeFramesAreOneApart) {
  const auto opened = [&](const std::string& name, const VolumeOptions& options) {
    auto frames = openVolumeFrames(std::vector{folder_ / name}, options);
    EXPECT_TRUE(frames) << frames.error().text();
    return std::move(*frames);
  };
  std::string unsaid = files_["raw.nrrd"];
  unsaid.replace(unsaid.find("nan 0.25"), 8, "nan nan");
  writeFile(folder_ / "unsaid.nrrd", unsaid);
  std::string still = files_["one.nii"];
  still.replace(76 + 16, 4, 4, '\0');  // pixdim[4]
  writeFile(folder_ / "still.nii", still);
  for (const char* name : {"unsaid.nrrd", "still.nii", "c.npy", "line.raw"}) {
    SCOPED_TRACE(name);
    const auto frames = opened(name, {});
    EXPECT_TRUE(frames.frames->isOneApart());
    EXPECT_EQ(frames.frames->frame(0)->time, 0);
    EXPECT_EQ(frames.frames->frame(1)->time, 1);
    EXPECT_EQ(opened(name, {.startTime = 5}).frames->frame(0)->time, 5);
    const auto given = opened(name, {.frameTime = 0.5});
    EXPECT_FALSE(given.frames->isOneApart());
    EXPECT_EQ(given.frames->frame(0)->time, 0);
    EXPECT_EQ(given.frames->frame(1)->time, 0.5);
  }
  EXPECT_FALSE(opened("raw.nrrd", {}).frames->isOneApart());
}

/// Fields and words of NRRD are compared without case, numbers are numbers, and what is said twice
/// is said once.
TEST_F(VolumeFiles, NrrdHeadersAreReadAsTheyAreMeant) {
  const model::Mesh expected = expectedMesh();
  const auto withHeader = [&](std::string name, const std::string& header) {
    const std::string& bytes = files_[name];
    const std::string path = "changed" + name;
    writeFile(folder_ / path, header + bytes.substr(bytes.find("\n\n") + 2));
    return path;
  };
  const auto headerOf = [&](const std::string& name) {
    return files_[name].substr(0, files_[name].find("\n\n") + 2);
  };
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::string raw = headerOf("raw.nrrd");
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"space directions", "Space Directions"},
           {"space directions", "spacedirections"},
           {"sizes", "SIZES"},
           {"type: float", "Type: FLOAT"},
           {"encoding: raw", "Encoding: RAW"},
           {"endian: little", "ENDIAN: Little"},
           {"kinds: space space space time", "Kinds: Domain SPACE ??? List"},
           {"space: left-posterior-superior", "space: LPS"},
           {"none\n", "NONE\n"},
           {"none\n", "(nan,nan,nan)\n"},
           {"space units", "units: \"\" \"\" \"\" \"s\"\nspace units"},
           {"space units", "units: \"mm\" \"mm\" \"mm\" \"s\"\nspace units"},
           {"spacings: nan nan nan", "spacings: 0.5 0.5 -0.5"},
           {"endian", "thicknesses: nan nan nan nan\nsample units: \"mm\"\nendian"},
           {"endian", "my key:=of: my own\nendian"},
       }) {
    SCOPED_TRACE(to);
    const std::string path = withHeader("raw.nrrd", replaced(raw, from, to));
    const auto mesh = wovenOf({folder_ / path}, {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    expectSameMesh(*mesh, expected);
    const auto opened = openVolumeFrames(std::vector{folder_ / path}, {});
    EXPECT_EQ(opened->lengthUnit, "mm");
    EXPECT_EQ(opened->timeUnit, to.find("\"s\"") == std::string::npos ? "" : "s");
    EXPECT_EQ(opened->space, "LPS");
  }
  for (const char* encoding : {"ASCII", "Text", "TXT"}) {
    const auto path = withHeader("text.nrrd", replaced(headerOf("text.nrrd"), "encoding: text",
                                                       std::string("encoding: ") + encoding));
    EXPECT_EQ(faultOf({folder_ / path}, {}), "") << encoding;
  }
  const std::string spaced =
      replaced(replaced(raw, "space directions: (0.5,0,0) (0,0.5,0) (0, 0, 0.5) none\n", ""),
               "nan nan nan", "0.5 0.5 0.5");
  EXPECT_EQ(faultOf({folder_ / withHeader("raw.nrrd", spaced)}, {}), "");
  const auto fault = [&](const std::string& header, const std::string& from,
                         const std::string& to) {
    return faultOf({folder_ / withHeader("raw.nrrd", replaced(header, from, to))}, {});
  };
  for (const char* word : {"0,5", "0.5mm", "1e999", "inf", "one", "0x1"}) {
    SCOPED_TRACE(word);
    const std::string numbers = std::string(word) + " 0.5 0.5";
    EXPECT_THAT(fault(spaced, "0.5 0.5 0.5", numbers), HasSubstr(fmt::format("has '{}'", word)));
    EXPECT_THAT(fault(raw, "endian", fmt::format("axis mins: {} 0\nendian", numbers)),
                HasSubstr(fmt::format("has '{}'", word)));
    EXPECT_NE(fault(raw, "(-1,2,0.25)", fmt::format("({};2;0.25)", word)), "");
    EXPECT_NE(fault(raw, "(0.5,0,0)", fmt::format("({},0,0,0)", word)), "");
    EXPECT_NE(fault(raw, "sizes: 5", fmt::format("sizes: {}", word)), "");
  }
  EXPECT_THAT(fault(spaced, "0.5 0.5 0.5", "nan 0.5 0.5"), HasSubstr("and nan for others"));
  EXPECT_THAT(fault(raw, "nan nan nan", "2 0.5 0.5"), HasSubstr("contradicts the direction"));
  EXPECT_THAT(fault(raw, "endian", "Sizes: 5 4 6 3\nendian"), HasSubstr("a second time"));
  EXPECT_THAT(fault(raw, "endian", "spacing: 2 2 2 1\nendian"),
              HasSubstr("the field 'spacing', which NRRD does not have"));
  EXPECT_THAT(fault(raw, "endian", "units: \"cm\" \"cm\" \"cm\" \"s\"\nendian"),
              HasSubstr("contradicts the space units, 'mm'"));
  EXPECT_THAT(fault(raw, "\"mm\" \"mm\" \"mm\"", "\"mm\" \"mm\" \"cm\""),
              HasSubstr("are not all the same"));
  EXPECT_THAT(fault(raw, "endian", "units: mm mm mm s\nendian"),
              HasSubstr("is not a unit in quotes"));
  EXPECT_THAT(fault(raw, "left-posterior-superior", "right-posterior-inferior"),
              HasSubstr("is not known"));
}

/// A solid is no mirror image in any space; positions are those of the file, or, of a left-handed
/// space, those with one axis turned round.
TEST_F(VolumeFiles, LeftHandedSpacesAreTurned) {
  const model::Mesh expected = expectedMesh();
  const auto inSpace = [&](const std::string& space) {
    std::string bytes = files_["raw.nrrd"];
    const std::string before = "left-posterior-superior";
    bytes.replace(bytes.find(before), before.size(), space);
    writeFile(folder_ / "in.nrrd", bytes);
    return openVolumeFrames(std::vector{folder_ / "in.nrrd"}, {});
  };
  const std::vector<std::tuple<const char*, const char*, int>> spaces = {
      {"left-posterior-superior", "LPS", -1},
      {"LPS", "LPS", -1},
      {"right-anterior-superior", "RAS", -1},
      {"Right-Anterior-Superior", "RAS", -1},
      {"left-anterior-superior", "RAS", 0},
      {"LAS", "RAS", 0},
      {"scanner-xyz", "", -1},
      {"3D-right-handed", "", -1},
      {"3D-left-handed", "", 2}};
  for (const auto& [space, name, turned] : spaces) {
    SCOPED_TRACE(space);
    const auto opened = inSpace(space);
    ASSERT_TRUE(opened) << opened.error().text();
    EXPECT_EQ(opened->space, name);
    EXPECT_EQ(opened->notice.empty(), turned < 0);
    const auto mesh = wovenOf({folder_ / "in.nrrd"}, {});
    ASSERT_TRUE(mesh);
    const auto found = measure::checkMesh(*mesh)->bounds;
    auto bounds = measure::checkMesh(expected)->bounds;
    if (turned >= 0) {
      std::swap(bounds.min[turned], bounds.max[turned]);
      bounds.min[turned] *= -1;
      bounds.max[turned] *= -1;
    }
    EXPECT_TRUE(found.min.isApprox(bounds.min) && found.max.isApprox(bounds.max));
  }
  for (const char* name : {"one.nii", "two_big.nii", "pair.hdr", "one_big.nii.gz"}) {
    EXPECT_EQ(openVolumeFrames(std::vector{folder_ / name}, {})->space, "RAS") << name;
  }
  std::string neither = files_["one.nii"];
  neither.replace(252, 4, 4, '\0');  // the codes of qform and sform
  writeFile(folder_ / "neither.nii", neither);
  EXPECT_EQ(openVolumeFrames(std::vector{folder_ / "neither.nii"}, {})->space, "");
}

/// A turn of x to y, y to z and z to x, with voxels of three lengths, mirrored or not: the same by
/// the quaternion of NIfTI as by its matrix.
TEST_F(VolumeFiles, NiftiSaysThePlaceInTwoWays) {
  const auto changed = [&](const std::map<std::size_t, std::vector<double>>& numbers, char qform,
                           char sform) {
    std::string bytes = files_["two.nii"];
    for (const auto& [at, values] : numbers) {
      std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(double));
    }
    bytes[344] = qform;
    bytes[348] = sform;
    writeFile(folder_ / "placed.nii", bytes);
    const auto mesh = wovenOf({folder_ / "placed.nii"}, {});
    EXPECT_TRUE(mesh) << mesh.error().text();
    return mesh.value_or(model::Mesh());
  };
  for (const double qfac : {1.0, -1.0}) {
    SCOPED_TRACE(qfac);
    const model::Mesh byMatrix =
        changed({{400, {0, 0, qfac * 0.25, -1, 0.5, 0, 0, 2, 0, 0.75, 0, 0.25}}}, 0, 1);
    const model::Mesh byQuaternion = changed(
        {{104, {qfac, 0.5, 0.75, 0.25}}, {352, {0.5, 0.5, 0.5}}, {376, {-1, 2, 0.25}}}, 1, 0);
    expectSameMesh(byQuaternion, byMatrix);
    EXPECT_TRUE(measure::checkMesh(byMatrix)->closed);
  }
}

/// With the axes in any order, in any encoding, one mesh comes out; a file is read once.
TEST_F(VolumeFiles, AxesMayBeInAnyOrder) {
  const model::Mesh expected = expectedMesh();
  std::string order = "txyz";
  do {
    std::array<int, 4> at{};
    constexpr std::array<int, 4> kSizes = {2, 5, 4, 6};
    const auto of = [](char axis) { return axis == 't' ? 0 : axis - 'w'; };
    std::string text;
    for (std::size_t i = 0; i < 240; ++i) {
      text += fmt::format("{}\n", volumeSample(at[1], at[2], at[3], at[0]));
      for (const char axis : order) {
        if (++at[of(axis)] < kSizes[of(axis)]) break;
        at[of(axis)] = 0;
      }
    }
    const auto time = order.find('t');
    std::string spaceAxes = order;
    spaceAxes.erase(time, 1);
    std::string directions;
    std::string sizes;
    for (const char axis : order) {
      directions += axis == 't'   ? " none"
                    : axis == 'x' ? " (0.5,0,0)"
                    : axis == 'y' ? " (0,0.5,0)"
                                  : " (0,0,0.5)";
      sizes += fmt::format(" {}", kSizes[of(axis)]);
    }
    writeFile(folder_ / "order.nrrd",
              fmt::format("NRRD0004\ntype: float\ndimension: 4\nsizes:{}\nspace: RAS\nspace "
                          "directions:{}\nspace origin: (-1,2,0.25)\nencoding: text\n\n{}",
                          sizes, directions, text));
    SCOPED_TRACE(order);
    const auto mesh = wovenOf({folder_ / "order.nrrd"}, {.frameTime = 0.25});
    ASSERT_TRUE(mesh) << mesh.error().text();
    const auto report = measure::checkMesh(*mesh);
    const auto wanted = measure::checkMesh(expected);
    EXPECT_TRUE(report->closed && report->oriented);
    EXPECT_TRUE(report->bounds.min.isApprox(wanted->bounds.min));
    EXPECT_TRUE(report->bounds.max.isApprox(wanted->bounds.max));
    if (spaceAxes != "xyz") continue;
    expectSameMesh(*mesh, expected);
    // Without directions, axes begin at mins of their own.
    std::string kinds;
    std::string spacings;
    std::string mins;
    for (const char axis : order) {
      kinds += axis == 't' ? " time" : " space";
      spacings += axis == 't' ? " 0.25" : " 0.5";
      mins += axis == 't' ? " 0" : axis == 'x' ? " -1" : axis == 'y' ? " 2" : " 0.25";
    }
    writeFile(folder_ / "mins.nrrd",
              fmt::format("NRRD0004\ntype: float\ndimension: 4\nsizes:{}\nkinds:{}\n"
                          "spacings:{}\naxis mins:{}\nencoding: text\n\n{}",
                          sizes, kinds, spacings, mins, text));
    const auto byMins = wovenOf({folder_ / "mins.nrrd"}, {});
    ASSERT_TRUE(byMins) << byMins.error().text();
    expectSameMesh(*byMins, expected);
  } while (std::ranges::next_permutation(order).found);
}

/// What may never begin or never end is not opened, and links lead to no other folder.
TEST_F(VolumeFiles, PipesAndLinksThatLeadOutAreRefused) {
  for (const std::string_view extension : volumeExtensions()) {
    const fs::path pipe = folder_ / ("pipe" + std::string(extension));
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(faultOf({pipe}, placed()), HasSubstr("is not a regular file"));
    const fs::path folder = folder_ / ("folder" + std::string(extension));
    fs::create_directory(folder);
    EXPECT_THAT(faultOf({folder}, placed()), HasSubstr("is a folder"));
  }
  fs::create_directories(folder_ / "in");
  writeFile(folder_ / "in/pattern.nhdr", files_["pattern.nhdr"]);
  writeFile(folder_ / "in/pair.hdr", files_["pair.hdr"]);
  fs::create_symlink("../f01.raw", folder_ / "in/f01.raw");
  fs::create_symlink("../pair.img", folder_ / "in/pair.img");
  writeFile(folder_ / "in/f02.raw", files_["f02.raw"]);
  EXPECT_THAT(faultOf({folder_ / "in/pattern.nhdr"}, {}),
              HasSubstr("names the data file 'f01.raw'; it must be in the same folder or below"));
  EXPECT_THAT(faultOf({folder_ / "in/pair.hdr"}, {}),
              HasSubstr("names the data file 'pair.img'; it must be in the same folder or below"));
  fs::remove(folder_ / "in/f01.raw");
  fs::create_directories(folder_ / "in/below");
  writeFile(folder_ / "in/below/data", files_["f01.raw"]);
  fs::create_symlink("below/data", folder_ / "in/f01.raw");
  EXPECT_EQ(faultOf({folder_ / "in/pattern.nhdr"}, {}), "");
  fs::remove(folder_ / "in/f01.raw");
  ASSERT_EQ(::mkfifo((folder_ / "in/f01.raw").c_str(), 0600), 0);
  EXPECT_THAT(faultOf({folder_ / "in/pattern.nhdr"}, {}), HasSubstr("is not a regular file"));
  std::string twice = files_["list.nhdr"];
  twice.replace(twice.find("f02.raw"), 7, "f01.raw");
  writeFile(folder_ / "twice.nhdr", twice);
  EXPECT_THAT(faultOf({folder_ / "twice.nhdr"}, {}), HasSubstr("names a file twice"));
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
