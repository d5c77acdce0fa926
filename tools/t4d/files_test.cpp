#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fixtures/polytopes.h"
#include "formats/output_file.h"
#include "formats/test_files.h"
#include "formats/text/base64.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"
#include "tools/t4d/convert.h"
#include "tools/t4d/du.h"
#include "tools/t4d/info.h"
#include "tools/t4d/members.h"
#include "tools/t4d/mend.h"
#include "tools/t4d/test_moving_cube.h"
#include "tools/t4d/view.h"

/// Verbs that take a file, and write another or tell what is in it.
namespace t4d::tools {
namespace {

using formats::temporaryPath;
using nlohmann::json;
using platform::contents;
using testing::HasSubstr;

/// The hypervolume of the unit cube that moves for 4 units of time.
constexpr double kHypervolume = 4;

std::string movingCubeFile(const std::string& name) {
  const model::Mesh mesh = movingCube(0, 4);
  const std::string path = temporaryPath(name).string();
  formats::Metadata metadata;
  metadata.bodies = {{"cube"}};
  auto writer = formats::T4dWriter::create(path, metadata);
  EXPECT_TRUE(writer && model::pump(mesh, writer->body(0)) && writer->finish());
  return path;
}

double hypervolumeIn(const std::string& path) {
  const auto input = openInput(path);
  EXPECT_TRUE(input) << input.error().text();
  const auto report = measure::checkMesh(*input->bodies.front().source);
  EXPECT_TRUE(report && report->valid());
  return report->hypervolume;
}

TEST(Mend, FillsTheHoleInACube) {
  formats::NamedMesh open{"cube", fixtures::cube(2)};
  open.mesh.triangles.pop_back();
  const std::string input = temporaryPath("open.ply").string();
  ASSERT_TRUE(formats::writeTriangleMeshes(input, {&open, 1}));
  const auto report = mend({.input = input, .output = temporaryPath("closed.ply").string()});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->mended.size(), 1);
  EXPECT_EQ(report->triangles, 12);
  EXPECT_NEAR(report->mended.front().report.volumeAfter, 8, 1e-12);
  const json value = json::parse(reportText(*report));
  EXPECT_TRUE(value["volume_before"].is_null());
  EXPECT_EQ(value["vertices"], 8);
  const auto onto = mend({.input = input, .output = input});
  ASSERT_FALSE(onto);
  EXPECT_EQ(onto.error().code, ErrorCode::Options);
}

TEST(Convert, ThereAndBackKeepsTheHypervolume) {
  const std::string input = movingCubeFile("there.t4d");
  const std::string there = temporaryPath("there.mesh").string();
  const auto converted = convert({.input = input, .output = there});
  ASSERT_TRUE(converted) << converted.error().text();
  EXPECT_EQ(converted->from, "t4d");
  EXPECT_EQ(converted->to, "medit");
  EXPECT_THAT(converted->losses,
              testing::ElementsAre("name of the body not kept by medit: 'cube'",
                                   "attributes not kept by medit: kind, triangle"));
  const std::string back = temporaryPath("back.t4d").string();
  const auto again = convert({.input = there, .output = back, .slabs = 2});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_TRUE(again->closed && again->oriented);
  EXPECT_NEAR(hypervolumeIn(back), kHypervolume, 1e-12);
  const json value = json::parse(reportText(*again));
  EXPECT_EQ(value["in"]["format"], "medit");
  EXPECT_EQ(value["out"]["format"], "t4d");
}

TEST(Convert, WhatAFileHasIsLostAndNothingElse) {
  const std::string off = temporaryPath("16-cell.off").string();
  ASSERT_TRUE(formats::writeOutputFile(off, fixtures::offText(fixtures::cell16())));
  const std::string plain = temporaryPath("plain.t4d").string();
  ASSERT_TRUE(convert({.input = off, .output = plain}));
  const auto lossesWith = [&](const formats::Metadata& metadata) {
    const std::string file = temporaryPath("16-cell.t4d").string();
    const auto reader = formats::T4dReader::open(plain);
    auto writer = formats::T4dWriter::create(file, metadata);
    EXPECT_TRUE(writer && model::pump(reader->body(0), writer->body(0)) && writer->finish());
    const auto report = convert({.input = file, .output = off});
    EXPECT_TRUE(report);
    return report->losses;
  };
  formats::Metadata metadata;
  metadata.bodies = {{"16-cell"}};
  EXPECT_THAT(lossesWith(metadata), testing::IsEmpty());
  metadata.timeUnit = "s";
  metadata.bodies[0].detailsJson = R"({"mass":2})";
  EXPECT_THAT(lossesWith(metadata),
              testing::ElementsAre("metadata not kept by off-stella: units",
                                   "details of bodies not kept by off-stella: 16-cell"));
  metadata.up = "z";
  metadata.detailsJson = R"({"source":"a program"})";
  EXPECT_THAT(lossesWith(metadata),
              testing::Contains("metadata not kept by off-stella: units, the upward axis, how the "
                                "mesh was made"));
}

TEST(Convert, RefusesFormatsThatThereAreNotAndWhatAT4dExcludes) {
  const std::string input = movingCubeFile("refused.t4d");
  const std::string output = temporaryPath("refused.mesh").string();
  for (const ConvertOptions& options :
       {ConvertOptions{.input = input, .output = input},
        ConvertOptions{.input = input, .output = temporaryPath("refused.xyz").string()},
        ConvertOptions{.input = input, .output = output, .to = "xyz"},
        ConvertOptions{.input = output, .output = input, .from = "xyz"},
        ConvertOptions{.input = input, .output = output, .slabs = 2},
        ConvertOptions{.input = input, .output = output, .weld = 0}}) {
    const auto refused = convert(options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Options);
  }
  EXPECT_FALSE(std::filesystem::exists(output));
}

TEST(Info, CountsWhatTheMeshHas) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = info(movingCubeFile("counted.t4d"), {.slabs = true});
  ASSERT_TRUE(report) << report.error().text();
  const formats::BodySummary total = report->total();
  EXPECT_EQ(total.slabs, mesh.slabCount());
  EXPECT_EQ(total.time.end, 4);
  ASSERT_EQ(report->slabs.size(), 1);
  std::uint64_t cells = 0;
  for (const formats::T4dSlab& slab : report->slabs.front()) cells += slab.cells;
  EXPECT_EQ(total.tetrahedra, cells);
  const json value = json::parse(reportText(*report));
  EXPECT_EQ(value["bodies"][0]["slab_list"].size(), mesh.slabCount());
}

TEST(Du, AccountsForAllBytes) {
  const std::string path = movingCubeFile("bytes.t4d");
  const auto report = du(path);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->bytes, std::filesystem::file_size(path));
  std::uint64_t sum = report->otherBytes;
  for (const formats::T4dChunks& chunks : report->chunks) sum += chunks.bytes;
  EXPECT_EQ(sum, report->bytes);
  EXPECT_TRUE(
      std::ranges::is_sorted(report->chunks, std::ranges::greater(), &formats::T4dChunks::bytes));
  EXPECT_EQ(json::parse(reportText(*report))["other_bytes"], report->otherBytes);
}

/// A page that is made as the viewer's is.
constexpr const char* kViewer = "<!-- This page is part of t4d, a test. --><p><!-- files --></p>";

TEST(View, PutsTheFileIntoThePageOrBesideIt) {
  const std::string input = movingCubeFile("viewed.t4d");
  const std::string bytes = platform::contents(input);
  ViewOptions options{
      .inputs = {input}, .viewer = kViewer, .output = temporaryPath("viewed.html").string()};
  const auto page = view(options);
  ASSERT_TRUE(page) << page.error().text();
  EXPECT_EQ(page->files, std::vector<std::string>{"viewed.t4d"});
  EXPECT_EQ(page->bytes, std::filesystem::file_size(options.output));
  EXPECT_THAT(platform::contents(options.output),
              HasSubstr(formats::base64(std::vector<std::uint8_t>(bytes.begin(), bytes.end()))));
  EXPECT_TRUE(json::parse(reportText(*page))["url"].is_null());

  const auto folder = temporaryPath("site");
  options.output = folder.string();
  for (int i = 0; i < 2; ++i) {  // a site of our own is replaced
    const auto site = view(options);
    ASSERT_TRUE(site) << site.error().text();
    EXPECT_EQ(platform::contents(folder / "viewed.t4d"), bytes);
  }
}

TEST(View, RefusesAnotherPageAndAFolderOfOthers) {
  const std::string input = movingCubeFile("not-viewed.t4d");
  ViewOptions options{
      .inputs = {input}, .viewer = "<p></p>", .output = temporaryPath("not-viewed.html").string()};
  const auto another = view(options);
  ASSERT_FALSE(another);
  EXPECT_EQ(another.error().code, ErrorCode::Options);
  options.viewer = kViewer;
  options.output = temporaryPath("others").string();
  std::filesystem::create_directories(options.output);
  formats::writeFile("others/index.html", "");
  const auto others = view(options);
  ASSERT_FALSE(others);
  EXPECT_EQ(others.error().code, ErrorCode::Options);
}

}  // namespace
}  // namespace t4d::tools
