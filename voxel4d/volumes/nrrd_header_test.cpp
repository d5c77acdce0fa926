#include <array>
#include <bit>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "platform/test_folder.h"
#include "t4d/frames.h"

namespace t4d::voxel4d {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<int, 4> kPoints = {6, 5, 4, 3};  // along x, y, z, t

/// In frame t of three, one sample is not 0: (1 + t, 2, 1).
std::string markedSamples(const std::string& axes) {
  std::string bytes;
  std::array<int, 4> at{};
  const auto axisOf = [](char name) { return name == 't' ? 3 : name - 'x'; };
  for (;;) {
    bytes += at[0] == 1 + at[3] && at[1] == 2 && at[2] == 1 ? '\1' : '\0';
    std::size_t i = 0;
    while (i < axes.size() && ++at[axisOf(axes[i])] == kPoints[axisOf(axes[i])]) {
      at[axisOf(axes[i++])] = 0;
    }
    if (i == axes.size()) return bytes;
  }
}

std::string gzipOf(const std::string& bytes) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string packed(bytes.size() + 1000, '\0');
  std::string from = bytes;
  stream.next_in = reinterpret_cast<unsigned char*>(from.data());
  stream.avail_in = static_cast<unsigned>(from.size());
  stream.next_out = reinterpret_cast<unsigned char*>(packed.data());
  stream.avail_out = static_cast<unsigned>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// What a file says: the time of each frame, and where its sample is in space.
struct Read {
  std::vector<double> times;
  std::vector<std::array<double, 3>> marks;
  std::string space;
  std::string notice;
  std::string lengthUnit;
  std::string timeUnit;
  bool isOneApart = false;
};

class NrrdFile : public testing::Test {
 protected:
  /// A header with these lines and the sizes of `axes`, and what follows the blank line.
  Result<Read> read(const std::string& axes, const std::string& lines, const std::string& data,
                    const std::string& encoding = "raw") {
    std::string header = "NRRD0005\ntype: uint8\ndimension: 4\nsizes:";
    for (const char name : axes) {
      header += fmt::format(" {}", kPoints[name == 't' ? 3 : name - 'x']);
    }
    const auto path = folder_ / "x.nrrd";
    std::ofstream(path, std::ios::binary) << header << "\n"
                                          << lines << "encoding: " << encoding << "\n\n"
                                          << data;
    auto opened = openVolumeFrames(std::vector{path}, {.iso = 0.5});
    if (!opened) return opened.error();
    Read found{{},
               {},
               opened->space,
               opened->notice,
               opened->lengthUnit,
               opened->timeUnit,
               opened->frames->isOneApart()};
    const model::Affine3x4 place = opened->toSpace.value_or(opened->frames->lattice().place());
    for (std::size_t i = 0; i < opened->frames->frameCount(); ++i) {
      const auto frame = opened->frames->frame(i);
      if (!frame) return frame.error();
      found.times.push_back(frame->time);
      EXPECT_EQ(countInside(*frame), 1U);
      for (const Block& block : frame->blocks) {
        for (int x = 0; x < 8; ++x) {
          if (block.inside[x] == 0) continue;
          const int bit = std::countr_zero(block.inside[x]);
          const Eigen::Vector3d point(x, bit / 8, bit % 8);
          const Eigen::Vector3d at = place.leftCols<3>() * point + place.col(3);
          found.marks.push_back({at.x(), at.y(), at.z()});
        }
      }
    }
    return found;
  }
  Result<Read> read(const std::string& lines) { return read("xyzt", lines, markedSamples("xyzt")); }
  std::string faultOf(const std::string& lines) {
    const auto found = read(lines);
    return found ? "" : folder_.without(found.error().text());
  }

  platform::TestFolder folder_;
};

using Marks = std::vector<std::array<double, 3>>;
using Times = std::vector<double>;

constexpr const char* kPlaced =
    "space directions: (2,0,0) (0,2,0) (0,0,2) none\nspace origin: (10,20,30)\n"
    "space: left-posterior-superior\n";
const Marks kPlacedMarks = {{12, 24, 32}, {14, 24, 32}, {16, 24, 32}};

TEST_F(NrrdFile, SpacesOfFourDimensionsHaveTheTime) {
  const std::string vectors =
      "space directions: (2,0,0,0) (0,2,0,0) (0,0,2,0) (0,0,0,0.5)\n"
      "space origin: (10,20,30,7)\nkinds: domain domain domain domain\n";
  for (const auto& [space, expected] : std::vector<std::pair<std::string, std::string>>{
           {"space dimension: 4", ""},
           {"space: left-posterior-superior-time", "LPS"},
           {"space: LPST", "LPS"},
           {"space: Right-Anterior-Superior-Time", "RAS"},
           {"space: scanner-xyz-time", ""},
           {"space: 3DRHT", ""},
       }) {
    SCOPED_TRACE(space);
    const auto found = read(space + "\n" + vectors);
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(found->times, (Times{7, 7.5, 8}));
    EXPECT_EQ(found->marks, kPlacedMarks);
    EXPECT_EQ(found->space, expected);
    EXPECT_EQ(found->notice, "");
    EXPECT_FALSE(found->isOneApart);
  }
  const auto turned = read("space: left-anterior-superior-time\n" + vectors);
  ASSERT_TRUE(turned) << turned.error().text();
  EXPECT_EQ(turned->marks, (Marks{{-12, 24, 32}, {-14, 24, 32}, {-16, 24, 32}}));
  EXPECT_THAT(turned->notice, HasSubstr("x is negated"));
}

TEST_F(NrrdFile, TheTimeOfASpaceMayBeAnyAxis) {
  const auto first = read("txyz",
                          "space: LPST\nspace directions: (0,0,0,0.5) (2,0,0,0) (0,2,0,0) "
                          "(0,0,2,0)\nspace origin: (10,20,30,0)\nspace units: \"mm\" \"mm\" "
                          "\"mm\" \"s\"\n",
                          markedSamples("txyz"));
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_EQ(first->times, (Times{0, 0.5, 1}));
  EXPECT_EQ(first->marks, kPlacedMarks);
  EXPECT_EQ(first->lengthUnit, "mm");
  EXPECT_EQ(first->timeUnit, "s");
  // A list has no direction in space.
  const auto list = read("xyzt",
                         "space: LPST\nspace directions: (2,0,0,0) (0,2,0,0) (0,0,2,0) none\n"
                         "space origin: (10,20,30,0)\nspacings: nan nan nan 0.25\n",
                         markedSamples("xyzt"));
  ASSERT_TRUE(list) << list.error().text();
  EXPECT_EQ(list->times, (Times{0, 0.25, 0.5}));
  EXPECT_EQ(list->marks, kPlacedMarks);
}

TEST_F(NrrdFile, SpacesThatMixSpaceAndTimeAreRefused) {
  const auto withDirections = [&](const std::string& directions) {
    return faultOf("space dimension: 4\nspace directions: " + directions + "\n");
  };
  for (const char* directions : {"(1,0,0,0.5) (0,1,0,0) (0,0,1,0) (0,0,0,0.5)",
                                 "(1,0,0,0) (0,1,0,0) (0,0,1,0) (1,0,0,0.5)"}) {
    EXPECT_THAT(withDirections(directions), HasSubstr("mixes space and time")) << directions;
  }
  EXPECT_THAT(withDirections("(1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,0)"),
              HasSubstr("none is the time"));
  EXPECT_THAT(withDirections("(1,0,0) (0,1,0) (0,0,1) none"),
              HasSubstr("is not a vector (x,y,z,t), or none, for each of 4 axes"));
  EXPECT_THAT(withDirections("(1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,-0.5)"),
              HasSubstr("expected a positive number"));
  EXPECT_EQ(faultOf("space: LPST\nspace dimension: 3\n"),
            "x.nrrd: its field 'space dimension: 3' contradicts the space 'LPST', which has 4");
  EXPECT_THAT(faultOf("space dimension: 5\n"), HasSubstr("is not 3, or 4 with the time"));
  EXPECT_THAT(faultOf("space: LPST\nspace directions: (2,0,0,0) (0,2,0,0) (0,0,2,0) (0,0,0,1)\n"
                      "spacings: nan nan nan 2\n"),
              HasSubstr("contradicts the direction of axis 3, along which frames are 1 apart"));
  EXPECT_THAT(faultOf("space: LPST\nspace directions: (2,0,0,0) (0,2,0,0) (0,0,2,0) (0,0,0,1)\n"
                      "space units: \"mm\" \"mm\" \"mm\"\n"),
              HasSubstr("is not a unit in quotes for each of 4 dimensions"));
}

TEST_F(NrrdFile, AFieldMayBeGivenAgainWithTheSameValue) {
  const std::string space = "space: left-posterior-superior\n";
  const auto found = read(kPlaced + space + "Space:  left-posterior-superior \n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->marks, kPlacedMarks);
  EXPECT_THAT(faultOf(kPlaced + std::string("space: RAS\n")),
              HasSubstr("has the field 'space' a second time, now with the value 'RAS' instead of "
                        "'left-posterior-superior'"));
}

TEST_F(NrrdFile, IndexValuesOfSequencesAreTimes) {
  const std::string list = std::string(kPlaced) + "kinds: domain domain domain list\n";
  const auto found = read(list +
                          "units: \"\" \"\" \"\" \"s\"\naxis 3 index type:=numeric\n"
                          "axis 3 index values:=0 0.25 2\n");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->times, (Times{0, 0.25, 2}));
  EXPECT_EQ(found->marks, kPlacedMarks);
  EXPECT_EQ(found->timeUnit, "s");
  EXPECT_FALSE(found->isOneApart);
  // 3D Slicer writes numbers encoded as in URLs, and with the list as the first axis.
  const auto encoded = read("txyz",
                            "space: left-posterior-superior\nspace directions: none (2,0,0) "
                            "(0,2,0) (0,0,2)\nspace origin: (10,20,30)\nkinds: list domain domain "
                            "domain\nlabels: \"time\" \"\" \"\" \"\"\nmeasurement frame: (1,0,0) "
                            "(0,1,0) (0,0,1)\naxis 0 index type:=numeric\n"
                            "axis 0 index values:=%2D1%2E5 0 1e1\n",
                            markedSamples("txyz"));
  ASSERT_TRUE(encoded) << encoded.error().text();
  EXPECT_EQ(encoded->times, (Times{-1.5, 0, 10}));
  EXPECT_EQ(encoded->marks, kPlacedMarks);
  // These are values of another axis.
  const auto other = read(list + "axis 0 index values:=5 6 7 8 9 10\n");
  ASSERT_TRUE(other) << other.error().text();
  EXPECT_EQ(other->times, (Times{0, 1, 2}));
  EXPECT_TRUE(other->isOneApart);
  const auto texts = read(list + "axis 3 index type:=text\naxis 3 index values:=a b c\n");
  ASSERT_TRUE(texts) << texts.error().text();
  EXPECT_EQ(texts->times, (Times{0, 1, 2}));
  EXPECT_TRUE(texts->isOneApart);
  EXPECT_EQ(texts->notice, "its 'axis 3 index values' are texts, so they are not used as times");
  EXPECT_EQ(faultOf(list + "axis 3 index values:=0 1\n"),
            "x.nrrd: its 'axis 3 index values' has 2 values for 3 frames");
  EXPECT_EQ(faultOf(list + "axis 3 index values:=0 2 1\n"),
            "x.nrrd: its 'axis 3 index values' has 1 for frame 2, after 2; times must increase");
  EXPECT_THAT(faultOf(list + "axis 3 index values:=0 1 late\n"),
              HasSubstr("has 'late' where a number is expected"));
}

TEST_F(NrrdFile, LinesAndBytesBeforeTheSamplesAreSkipped) {
  const std::string samples = markedSamples("xyzt");
  const auto marksOf = [&](const std::string& skips, const std::string& data,
                           const std::string& encoding) {
    const auto found = read("xyzt", kPlaced + skips, data, encoding);
    EXPECT_TRUE(found) << found.error().text();
    return found ? found->marks : Marks();
  };
  EXPECT_EQ(marksOf("line skip: 2\n", "one\ntwo\n" + samples, "raw"), kPlacedMarks);
  EXPECT_EQ(marksOf("line skip: 1\nbyte skip: 3\n", "one\nabc" + samples, "raw"), kPlacedMarks);
  EXPECT_EQ(marksOf("byte skip: -1\n", "one\nabc" + samples, "raw"), kPlacedMarks);
  EXPECT_EQ(marksOf("line skip: 1\n", "one\n" + gzipOf(samples), "gzip"), kPlacedMarks);
  EXPECT_EQ(marksOf("byte skip: 5\n", gzipOf("12345" + samples), "gzip"), kPlacedMarks);
  EXPECT_EQ(marksOf("byte skip: -1\n", gzipOf("any number" + samples), "gzip"), kPlacedMarks);
  EXPECT_EQ(marksOf("line skip: 1\nbyte skip: -1\n", "one\n" + gzipOf("ab" + samples), "gzip"),
            kPlacedMarks);
  std::string text;
  for (const char sample : samples) text += sample == 0 ? "0 " : "1 ";
  EXPECT_EQ(marksOf("line skip: 1\n", "7 7 7\n" + text, "text"), kPlacedMarks);
  EXPECT_EQ(marksOf("byte skip: 4\n", "7 7 " + text, "text"), kPlacedMarks);

  const auto refusalOf = [&](const std::string& skips, const std::string& data,
                             const std::string& encoding) {
    const auto found = read("xyzt", kPlaced + skips, data, encoding);
    return found ? "" : folder_.without(found.error().text());
  };
  EXPECT_THAT(refusalOf("line skip: -1\n", samples, "raw"),
              HasSubstr("is not a number of lines to skip"));
  EXPECT_EQ(refusalOf("line skip: 9\n", "a\nb\n" + samples, "raw"),
            "x.nrrd: is cut off: it has 2 lines to skip; its header says 9");
  EXPECT_THAT(refusalOf("byte skip: -1\n", gzipOf("abc"), "gzip"),
              HasSubstr("360 bytes of samples are expected at its end, and it has 3"));
  EXPECT_THAT(refusalOf("byte skip: -1\n", "abc", "raw"), HasSubstr("and it has 3"));
  EXPECT_THAT(refusalOf("byte skip: -1\n", gzipOf(samples).substr(0, 20), "gzip"),
              HasSubstr("is cut off"));
  EXPECT_THAT(refusalOf("byte skip: -1\n", "1 1 1", "text"),
              HasSubstr("is not a number of bytes to skip"));
}

TEST_F(NrrdFile, FramesThatDifferSayInWhatAndByHowMuch) {
  const auto write = [&](const std::string& name, const std::string& from = "",
                         const std::string& to = "") {
    std::string header =
        "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nspace: left-posterior-superior\n"
        "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (10,20,30)\n"
        "space units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n";
    if (!from.empty()) header.replace(header.find(from), from.size(), to);
    std::ofstream(folder_ / name, std::ios::binary) << header << "\n" << std::string(24, '\1');
  };
  write("a.nrrd");
  const auto refusalOf = [&](const std::string& from, const std::string& to) {
    write("b.nrrd", from, to);
    const auto opened =
        openVolumeFrames(std::vector{folder_ / "a.nrrd", folder_ / "b.nrrd"}, {.iso = 0.5});
    return opened ? "(was accepted)" : folder_.without(opened.error().text());
  };
  EXPECT_EQ(refusalOf("", ""), "(was accepted)");
  EXPECT_EQ(refusalOf("sizes: 4 3 2", "sizes: 2 6 2"),
            "b.nrrd: has 2 samples along x, 2 fewer than the first frame (a.nrrd), which has 4");
  EXPECT_EQ(refusalOf("sizes: 4 3 2", "sizes: 4 6 1"),
            "b.nrrd: has 6 samples along y, 3 more than the first frame (a.nrrd), which has 3");
  EXPECT_EQ(refusalOf("uint8", "int8"),
            "b.nrrd: has samples of type int8, the first frame (a.nrrd) of type uint8");
  EXPECT_EQ(refusalOf("\"mm\" \"mm\" \"mm\"", "\"cm\" \"cm\" \"cm\""),
            "b.nrrd: has the units 'cm' and '', the first frame (a.nrrd) 'mm' and ''");
  EXPECT_EQ(refusalOf("left-posterior-superior", "right-anterior-superior"),
            "b.nrrd: has positions in the space 'RAS', the first frame (a.nrrd) in 'LPS'");
  EXPECT_THAT(refusalOf("(10,20,30)", "(10,20,33)"),
              HasSubstr("its first sample is (10, 20, 33), that of the first frame (10, 20, 30)"));
  EXPECT_THAT(
      refusalOf("(0,2,0)", "(0,2.5,0)"),
      HasSubstr("its voxel edge along y is (0, 2.5, 0), that of the first frame (0, 2, 0)"));
}

}  // namespace
}  // namespace t4d::voxel4d
