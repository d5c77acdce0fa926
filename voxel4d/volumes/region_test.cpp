#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "t4d/frames.h"
#include "t4d/mesh.h"
#include "t4d/weave.h"
#include "voxel4d/volumes/volume_samples.h"

namespace t4d::voxel4d {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// The 4D mesh of volumes, and what is said of them.
struct Woven {
  model::Mesh mesh;
  std::string notice;
  std::string fault;
};

Woven woven(const std::vector<fs::path>& files, const VolumeOptions& options) {
  Woven result;
  auto opened = openVolumeFrames(files, options);
  if (!opened) return {{}, {}, opened.error().text()};
  model::Transformed toSpace(result.mesh, {opened->toSpace.value_or(model::Affine3x4::Identity())});
  auto report = opened->toSpace ? weave(*opened->frames, {}, toSpace)
                                : weave(*opened->frames, {}, result.mesh);
  if (!report) result.fault = report.error().text();
  result.notice = opened->frames->notice();
  return result;
}

/// One mesh is the other, bit for bit.
void expectSame(const Woven& a, const Woven& b) {
  ASSERT_EQ(a.fault, b.fault);
  ASSERT_EQ(a.mesh.slabCount(), b.mesh.slabCount());
  for (std::size_t i = 0; i < a.mesh.slabCount(); ++i) {
    EXPECT_EQ(a.mesh.slabs()[i].vertices, b.mesh.slabs()[i].vertices);
    EXPECT_EQ(*a.mesh.slabs()[i].connectivity, *b.mesh.slabs()[i].connectivity);
  }
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

template <class T>
std::string stored(double value, bool swapped) {
  const auto sample = static_cast<T>(value);
  std::string bytes(reinterpret_cast<const char*>(&sample), sizeof sample);
  if (swapped) std::ranges::reverse(bytes);
  return bytes;
}

/// The coding of samples.
struct Coding {
  std::string axes = "xyzt";  // the fastest first
  std::string type = "float";
  std::string encoding = "raw";
  bool swapped = false;
};

/// Samples (x, y, z, t) of a range of each axis as NRRD, with voxels of 0.5 x 0.25 x 1 and frames
/// 0.125 apart from the time 0 on.
std::string nrrd(const std::array<Extent, 4>& ranges, const Coding& coding) {
  const auto axisOf = [](char name) { return name == 't' ? 3 : name - 'x'; };
  std::array<std::uint64_t, 4> at{};
  std::uint64_t count = 1;
  for (const Extent& range : ranges) count *= range.count;
  std::string data;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t rest = i;
    for (const char name : coding.axes) {
      const Extent& range = ranges[axisOf(name)];
      at[axisOf(name)] = range.begin + rest % range.count;
      rest /= range.count;
    }
    const auto [x, y, z, t] = at;
    // Waves, so that every region has a surface.
    const double value = std::round(50 + 40 * std::sin(0.9 * double(x) + 0.3 * double(t)) *
                                             std::cos(0.7 * double(y) - double(z)));
    if (coding.encoding == "text") {
      data += fmt::format("{}\n", value);
    } else if (coding.type == "float") {
      data += stored<float>(value, coding.swapped);
    } else if (coding.type == "double") {
      data += stored<double>(value, coding.swapped);
    } else if (coding.type == "short") {
      data += stored<std::int16_t>(value, coding.swapped);
    } else {
      data += stored<std::uint8_t>(value, false);
    }
  }
  const std::map<char, std::string> directions = {
      {'x', "(0.5,0,0)"}, {'y', "(0,0.25,0)"}, {'z', "(0,0,1)"}, {'t', "none"}};
  std::string head = fmt::format("NRRD0005\ntype: {}\ndimension: 4\nsizes:", coding.type);
  for (const char name : coding.axes) head += fmt::format(" {}", ranges[axisOf(name)].count);
  head += "\nspace: RAS\nspace directions:";
  for (const char name : coding.axes) head += " " + directions.at(name);
  head += fmt::format("\nspace origin: ({},{},{})\nspacings:", 3 + 0.5 * double(ranges[0].begin),
                      0.25 * double(ranges[1].begin) - 2, double(ranges[2].begin));
  for (const char name : coding.axes) head += name == 't' ? " 0.125" : " nan";
  head += fmt::format("\nendian: {}\nencoding: {}\n\n", coding.swapped ? "big" : "little",
                      coding.encoding);
  return head + (coding.encoding == "gzip" ? gzipped(data) : data);
}

IndexRange rangeOf(const Extent& extent) {
  return {static_cast<std::int64_t>(extent.begin),
          static_cast<std::int64_t>(extent.begin + extent.count)};
}

TEST(RegionOfAVolume, IsTheVolumeCroppedWithItsOriginMoved) {
  const platform::TestFolder folder;
  std::mt19937 random(11);
  const auto upTo = [&](std::uint64_t most) {
    return std::uniform_int_distribution<std::uint64_t>(0, most)(random);
  };
  constexpr std::array<std::uint64_t, 4> kSizes = {13, 9, 11, 5};
  for (int trial = 0; trial < 60; ++trial) {
    Coding coding;
    std::ranges::shuffle(coding.axes, random);
    constexpr std::array kTypes = {"float", "double", "short", "uchar"};
    constexpr std::array kEncodings = {"raw", "gzip", "text"};
    coding.type = kTypes[upTo(3)];
    coding.encoding = kEncodings[upTo(2)];
    coding.swapped = coding.encoding != "text" && upTo(1) == 1;
    std::array<Extent, 4> whole;
    std::array<Extent, 4> part;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint64_t least = i == 3 ? 2 : 1;
      whole[i] = {0, kSizes[i]};
      part[i].begin = upTo(kSizes[i] - least);
      part[i].count = least + upTo(kSizes[i] - part[i].begin - least);
    }
    SCOPED_TRACE(fmt::format("{}: {} {} {} {}", trial, coding.axes, coding.type, coding.encoding,
                             coding.swapped));
    write(folder / "whole.nrrd", nrrd(whole, coding));
    write(folder / "part.nrrd", nrrd(part, coding));
    VolumeOptions options;
    if (coding.type == "uchar" && upTo(1) == 0) {
      options.label = 50;
    } else {
      options.iso = 49.5;
    }
    // The region starts here in time.
    options.startTime = 0.125 * static_cast<double>(part[3].begin);
    const Woven expected = woven({folder / "part.nrrd"}, options);
    options.startTime = std::nullopt;
    // x, y and z are the axes of the file in their order.
    Region region{{}, rangeOf(part[3])};
    std::size_t axis = 0;
    for (const char name : coding.axes) {
      if (name != 't') region.space[axis++] = rangeOf(part[name - 'x']);
    }
    options.region = region;
    Woven found = woven({folder / "whole.nrrd"}, options);
    if (!found.fault.empty()) found.fault.replace(found.fault.find("whole"), 5, "part");
    expectSame(found, expected);
  }
}

TEST(RegionOfAVolume, IsTheSameInEveryFormat) {
  const platform::TestFolder folder;
  for (const auto& [name, bytes] : volumeSamples()) write(folder / name, bytes);
  VolumeOptions options{.frameTime = 0.25, .spacing = {{0.5, 0.5, 0.5}}, .origin = {{-1, 2, 0.25}}};
  options.region = Region{{{{1, 4}, {{}, 3}, {2, 5}}}, {}};
  const Woven expected = woven({folder / "raw.nrrd"}, options);
  ASSERT_EQ(expected.fault, "");
  EXPECT_THAT(expected.notice, HasSubstr("at x = 1"));
  int formats = 0;
  for (const auto& [name, bytes] : volumeSamples()) {
    if (name.ends_with(".img") || (name.ends_with(".raw") && name != "line.raw")) continue;
    SCOPED_TRACE(name);
    options.axes = name == "fortran.npy" ? "txyz" : "";
    expectSame(woven({folder / name}, options), expected);
    ++formats;
  }
  EXPECT_GT(formats, 12);
  options.axes = "";
  options.raw = "float32 5 4 6 little";
  expectSame(woven({folder / "f01.raw", folder / "f02.raw"}, options), expected);
}

TEST(RegionOfAVolume, OfSeveralFilesTakesSomeAtTheirTimes) {
  const platform::TestFolder folder;
  std::vector<fs::path> files;
  const Coding coding{.axes = "txyz"};
  for (std::uint64_t t = 0; t < 6; ++t) {
    files.push_back(folder / fmt::format("f{}.nrrd", t));
    write(files.back(), nrrd({{{0, 6}, {0, 7}, {0, 5}, {t, 1}}}, coding));
  }
  write(folder / "part.nrrd", nrrd({{{0, 6}, {2, 4}, {0, 5}, {2, 3}}}, coding));
  VolumeOptions options{.iso = 49.5, .frameTime = 0.125, .startTime = 10};
  options.region = Region{{{{}, {2, 6}, {}}}, {2, 5}};
  const Woven found = woven(files, options);
  const Woven expected = woven({folder / "part.nrrd"}, {.iso = 49.5, .startTime = 10.25});
  ASSERT_EQ(found.fault, "");
  expectSame(found, expected);
  // The middle of a detached header's files, too.
  const std::string whole = nrrd({{{0, 6}, {0, 7}, {0, 5}, {0, 6}}}, {});
  const auto data = whole.find("\n\n") + 2;
  std::string head = whole.substr(0, data - 1) + "data file: d%d.raw 0 5 1\n\n";
  const std::size_t frame = std::size_t{6} * 7 * 5 * sizeof(float);
  for (std::size_t t = 0; t < 6; ++t) {
    write(folder / fmt::format("d{}.raw", t), whole.substr(data + t * frame, frame));
  }
  write(folder / "list.nhdr", head);
  options.frameTime = std::nullopt;
  expectSame(woven({folder / "list.nhdr"}, options), expected);
}

TEST(RegionOfAVolume, IsAllThatIsReadOfIt) {
  const platform::TestFolder folder;
  // 64 GiB, of which nothing is on the disk but two blocks.
  constexpr std::uint64_t kSide = 3250;
  const std::string head = fmt::format("raw uint8 {0} {0} {0} 2\n", kSide);
  const fs::path path = folder / "huge.raw";
  write(path, head);
  std::error_code error;
  fs::resize_file(path, head.size() + 2 * kSide * kSide * kSide, error);
  if (error) GTEST_SKIP() << "no files with holes here";
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  for (std::uint64_t t = 0; t < 2; ++t) {
    const std::uint64_t sample = 2005 + kSide * (2005 + kSide * (2005 + kSide * t));
    file.seekp(static_cast<std::streamoff>(head.size() + sample));
    file.put(9);
  }
  file.close();
  VolumeOptions options{.iso = 4};
  options.region = Region{{{{2000, 2010}, {2000, 2010}, {2000, 2010}}}, {}};
  const Woven found = woven({path}, options);
  ASSERT_EQ(found.fault, "");
  EXPECT_EQ(found.notice, "");
  ASSERT_EQ(found.mesh.slabCount(), 3U);
  EXPECT_FALSE(found.mesh.slabs()[1].vertices.empty());
  for (const auto& slab : found.mesh.slabs()) {
    for (const auto& vertex : slab.vertices) EXPECT_NEAR(vertex[0], 2005, 0.6);
  }
}

TEST(RegionOfAVolume, SaysWhichSidesTheSolidReaches) {
  const platform::TestFolder folder;
  write(folder / "a.nrrd", nrrd({{{0, 13}, {0, 9}, {0, 11}, {0, 5}}}, {}));
  VolumeOptions options{.iso = 49.5};
  const auto noticeWith = [&](const std::string& region) {
    options.region = *parseRegion(region);
    return woven({folder / "a.nrrd"}, options).notice;
  };
  // The file's own border is none of the region's.
  EXPECT_EQ(noticeWith(":,:,:,1:3"), "");
  EXPECT_EQ(noticeWith("0:13,0:9,0:11,0:5"), "");
  EXPECT_THAT(noticeWith("2:,:,:"), testing::EndsWith("closed there: at x = 2"));
  EXPECT_THAT(noticeWith(":,:8,:10"), testing::EndsWith("closed there: at y = 7, z = 9"));
}

TEST(RegionOfAVolume, SaysWhatIsWrong) {
  const platform::TestFolder folder;
  write(folder / "a.nrrd", nrrd({{{0, 13}, {0, 9}, {0, 11}, {0, 5}}}, {}));
  write(folder / "one.nrrd", nrrd({{{0, 13}, {0, 9}, {0, 11}, {0, 1}}}, {.axes = "txyz"}));
  const auto faultOf = [&](const std::string& region, const std::string& name = "a.nrrd") {
    VolumeOptions options{.iso = 49.5};
    const auto parsed = parseRegion(region);
    if (!parsed) return parsed.error().text();
    options.region = *parsed;
    return woven({folder / name}, options).fault;
  };
  EXPECT_THAT(faultOf("3:14,:,:"),
              HasSubstr("a.nrrd: the region has 3:14 along x, where there are 13 samples"));
  EXPECT_THAT(faultOf(":,-1:,:"), HasSubstr("has -1: along y, where there are 9 samples"));
  EXPECT_THAT(faultOf(":,:,11:"), HasSubstr("has 11: along z, where there are 11 samples"));
  EXPECT_THAT(faultOf(":,:,:,2:6"), HasSubstr("has 2:6 along t, where there are 5 frames"));
  EXPECT_THAT(faultOf(":,:,:,2:3"), HasSubstr("one frame only; a 4D mesh needs two or more"));
  EXPECT_THAT(faultOf(":,:,:,4:"), HasSubstr("one frame only; a 4D mesh needs two or more"));
  EXPECT_THAT(faultOf(":,:,:,0:2", "one.nrrd"), HasSubstr("has one frame only"));
  EXPECT_THAT(faultOf("5:5,:,:"), HasSubstr("5:5 along x is empty"));
  EXPECT_THAT(faultOf(":,7:3,:"), HasSubstr("7:3 along y is empty"));
  EXPECT_THAT(faultOf(":,:"), HasSubstr("':,:' has 2 ranges; expected those"));
  EXPECT_THAT(faultOf(""), HasSubstr("has 1 ranges"));
  EXPECT_THAT(faultOf(":,:,:,:,:"), HasSubstr("has 5 ranges"));
  EXPECT_THAT(faultOf("1:2:3,:,:"), HasSubstr("'1:2:3' is not a range of whole numbers along x"));
  EXPECT_THAT(faultOf(":,7,:"), HasSubstr("'7' is not a range"));
  EXPECT_THAT(faultOf(":,:,1e3:"), HasSubstr("'1e3:' is not a range"));
  EXPECT_THAT(faultOf("99999999999999999999:,:,:"), HasSubstr("is not a range"));
}

}  // namespace
}  // namespace t4d::voxel4d
