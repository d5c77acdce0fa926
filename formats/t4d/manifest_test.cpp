#include "formats/t4d/manifest.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "fixtures/solids.h"
#include "formats/t4d/join.h"
#include "formats/t4d/salvage.h"
#include "formats/t4d/test_slabs.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#ifdef T4D_WITH_CURL
#include "tests/web_server.h"
#endif

namespace t4d::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using ManifestText = nlohmann::ordered_json;

/// A cube that turns, in files each of which has some of the steps.
class FileInParts : public testing::Test {
 protected:
  static constexpr std::uint64_t kParts = 4;

  static std::filesystem::path swept(const std::string& name, const model::Part& part,
                                     const T4dWriteOptions& options = {}) {
    model::ScrewRun run;
    run.duration = 1;
    run.screw.axisDirection = {0, 0, 1};
    run.screw.angleDegrees = 90;
    run.screw.translation = {0, 0, 0.3};
    const auto path = temporaryPath(name);
    auto writer = T4dWriter::create(path, metadataOf({"cube"}), options);
    mesh4d::SweepOptions how;
    how.steps = mesh4d::StepsPerSegment{24};
    how.part = part;
    const auto motion = *model::chainScrews(0.7, std::span(&run, 1));
    EXPECT_TRUE(mesh4d::sweep(fixtures::cube(1), motion, how, writer->body(0)));
    EXPECT_TRUE(writer->finish());
    return path;
  }

  void SetUp() override {
    for (std::uint64_t i = 1; i <= kParts; ++i) {
      parts_.push_back(swept("piece" + std::to_string(i) + ".t4d", {i, kParts}));
    }
    manifest_ = temporaryPath("cube.t4dm");
    const auto written = writeManifest(parts_, manifest_);
    ASSERT_TRUE(written) << written.error().text();
    text_ = platform::contents(manifest_);
  }
  void TearDown() override {
    for (const auto& part : parts_) std::filesystem::remove(part);
  }

  /// The manifest with a change.
  template <class Change>
  std::filesystem::path changed(Change change) const {
    ManifestText json = ManifestText::parse(text_);
    change(json);
    return writeFile("changed.t4dm", json.dump());
  }
  template <class Change>
  std::string errorWith(Change change) const {
    return errorOf(changed(change));
  }
  static std::string errorOf(const std::filesystem::path& path, T4dOpen how = T4dOpen::Whole) {
    const auto reader = T4dReader::open(path, how);
    return reader ? std::string() : reader.error().text();
  }

  std::vector<std::filesystem::path> parts_;
  std::filesystem::path manifest_;
  std::string text_;
};

TEST_F(FileInParts, IsTheFileThatJoinMakes) {
  const auto joined = temporaryPath("joined.t4d");
  ASSERT_TRUE(joinT4d(parts_, joined));
  for (const T4dOpen how : {T4dOpen::Whole, T4dOpen::Checked}) {
    const auto one = T4dReader::open(joined);
    const auto all = T4dReader::open(manifest_, how);
    ASSERT_TRUE(all) << all.error().text();
    ASSERT_EQ(all->bodyCount(), 1U);
    const BodySummary& a = one->summary(0);
    const BodySummary& b = all->summary(0);
    EXPECT_EQ(a.slabs, b.slabs);
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.tetrahedra, b.tetrahedra);
    EXPECT_EQ(a.time.begin, b.time.begin);
    EXPECT_EQ(a.time.end, b.time.end);
    EXPECT_TRUE(a.bounds.min == b.bounds.min && a.bounds.max == b.bounds.max);
    ASSERT_EQ(one->body(0).slabCount(), all->body(0).slabCount());
    for (std::size_t i = 0; i < one->body(0).slabCount(); ++i) {
      EXPECT_TRUE(same(**one->body(0).slab(i), **all->body(0).slab(i))) << i;
      EXPECT_EQ(one->body(0).timeSpan(i).begin, all->body(0).timeSpan(i).begin);
      EXPECT_EQ(one->body(0).cellCount(i), all->body(0).cellCount(i));
      EXPECT_EQ(one->slabContents(0, i)->cells, all->slabContents(0, i)->cells);
    }
    const auto report = measure::checkMesh(all->body(0));
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->closed && report->oriented);
  }
  EXPECT_TRUE(checkT4dFile(manifest_));
}

TEST_F(FileInParts, JoinMakesOneFileOfItAndAnotherManifest) {
  const auto direct = temporaryPath("direct.t4d");
  const auto through = temporaryPath("through.t4d");
  ASSERT_TRUE(joinT4d(parts_, direct));
  const auto joined = joinT4d({manifest_}, through);
  ASSERT_TRUE(joined) << joined.error().text();
  EXPECT_EQ(platform::contents(direct), platform::contents(through));
  const auto again = temporaryPath("again.t4dm");
  ASSERT_TRUE(writeManifest({manifest_}, again));
  EXPECT_EQ(platform::contents(again), text_);
}

TEST_F(FileInParts, IsMadeOfManifestsOfItsParts) {
  std::vector<std::filesystem::path> ones;
  for (const auto& part : parts_) {
    ones.push_back(temporaryPath(part.stem().string() + ".t4dm"));
    ASSERT_TRUE(writeManifest({part}, ones.back()));
  }
  const auto all = temporaryPath("all.t4dm");
  const auto written = writeManifest(ones, all);
  ASSERT_TRUE(written) << written.error().text();
  EXPECT_EQ(written->parts, kParts);
  EXPECT_EQ(platform::contents(all), text_);
  const auto gap = writeManifest({ones[0], ones[2]}, all);
  ASSERT_FALSE(gap);
  EXPECT_THAT(gap.error().text(), HasSubstr("begins at time"));
}

TEST_F(FileInParts, ReadsOnlyThePartThatHasTheTime) {
  const auto reader = T4dReader::open(manifest_);
  ASSERT_TRUE(reader) << reader.error().text();
  const model::Source& body = reader->body(0);
  EXPECT_EQ(reader->bytesRead(), 0U);
  for (std::size_t part = 0; part < kParts; ++part) {
    // The others are not even there.
    std::vector<std::filesystem::path> away;
    for (std::size_t i = 0; i < kParts; ++i) {
      if (i == part) continue;
      away.push_back(parts_[i].string() + ".away");
      std::filesystem::rename(parts_[i], away.back());
    }
    const auto fresh = T4dReader::open(manifest_);
    EXPECT_THAT(fresh ? "" : fresh.error().text(), HasSubstr("No such file"));
    const double time = 0.7 + (static_cast<double>(part) + 0.4) / kParts;
    EXPECT_TRUE(slice::sliceAtTime(body, time)) << part;
    for (const auto& name : away) std::filesystem::rename(name, name.parent_path() / name.stem());
  }
}

TEST_F(FileInParts, NamesAPartThatIsMissingOrExchanged) {
  const std::string own = platform::contents(parts_[2]);
  const auto reader = T4dReader::open(manifest_);
  ASSERT_TRUE(reader);
  std::filesystem::remove(parts_[2]);
  EXPECT_THAT(errorOf(manifest_), AllOf(HasSubstr("piece3.t4d: cannot open: No such file"),
                                        HasSubstr("(a part of "), HasSubstr("cube.t4dm")));
  // A part that goes away later is named where it is read, and its slabs keep a time.
  const model::Source& body = reader->body(0);
  const std::size_t last = body.slabCount() * 5 / 8;
  EXPECT_THAT(body.slab(last).error().text(), HasSubstr("piece3.t4d: cannot open"));
  EXPECT_LT(body.timeSpan(last).begin, body.timeSpan(last).end);
  // Another run: as long, but with other bytes.
  std::string other = own;
  other[other.size() - 45] ^= 1;
  writeFile("piece3.t4d", platform::contents(parts_[1]));
  EXPECT_THAT(errorOf(manifest_), HasSubstr("piece3.t4d: is not the part that"));
  const auto shorter = swept("piece3.t4d", {3, kParts}, {.compression = 0});
  EXPECT_THAT(errorOf(manifest_), HasSubstr("bytes, not"));
  // A byte in the middle: the footer is the same, so only a full check notices.
  other = own;
  other[other.size() / 3] ^= 1;
  writeFile("piece3.t4d", other);
  EXPECT_EQ(errorOf(manifest_), "");
  EXPECT_THAT(errorOf(manifest_, T4dOpen::Checked), HasSubstr("piece3.t4d: byte"));
  writeFile("piece3.t4d", own);
  EXPECT_EQ(errorOf(manifest_, T4dOpen::Checked), "");
  EXPECT_THAT(
      errorOf(changed([](auto& json) { json["parts"][2]["sha256"] = std::string(64, '0'); }),
              T4dOpen::Checked),
      HasSubstr("piece3.t4d: is not the part that"));
}

TEST_F(FileInParts, RefusesAManifestThatIsWrong) {
  const auto part = [](auto change) {
    return [change](ManifestText& json) { change(json["parts"][1]); };
  };
  const auto path = [&](const std::string& name) {
    return errorWith(part([&](auto& each) { each["path"] = name; }));
  };
  for (const std::string leaving : {"../piece2.t4d", "/etc/passwd", "a/../../b.t4d", "",
                                    "ftp://host/piece2.t4d", "file:///etc/passwd"}) {
    EXPECT_THAT(path(leaving), HasSubstr("without '..', or an http://")) << leaving;
  }
  const platform::TestFolder elsewhere;
  std::filesystem::copy_file(parts_[1], elsewhere / "piece2.t4d");
  const std::filesystem::path link = temporaryPath("link.t4d");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(elsewhere / "piece2.t4d", link);
  EXPECT_THAT(path("link.t4d"), HasSubstr("link.t4d: is a link to a file outside of the folder"));
  EXPECT_THAT(path("nothing.t4d"), HasSubstr("nothing.t4d: cannot open"));
  EXPECT_THAT(path("cube.t4dm"), HasSubstr("cube.t4dm: is not the part"));
  EXPECT_THAT(errorWith([](auto& json) { json["parts"].erase(1); }),
              HasSubstr("a part between them is missing"));
  EXPECT_THAT(errorWith([](auto& json) { json["parts"].push_back(json["parts"][3]); }),
              HasSubstr("they overlap"));
  EXPECT_THAT(errorWith([](auto& json) { json["parts"] = ManifestText::array(); }),
              HasSubstr("names no part"));
  EXPECT_THAT(errorWith([](auto& json) { json["t4dm"] = 2; }), HasSubstr("of version 2"));
  EXPECT_THAT(errorWith([](auto& json) { json.erase("head"); }),
              HasSubstr("'head' of the manifest must be an object"));
  EXPECT_THAT(errorWith([](auto& json) { json["head"]["features"] = {"future"}; }),
              HasSubstr("future"));
  for (const char* name :
       {"path", "bytes", "sha256", "footer", "slabs", "begin", "end", "bodies", "chunks"}) {
    EXPECT_THAT(errorWith(part([&](auto& each) { each.erase(name); })),
                HasSubstr(std::string("'") + name + "' of part 2 must be"));
  }
  for (const char* name : {"slabs", "vertices", "cells", "begin", "end", "min", "max", "shared"}) {
    EXPECT_THAT(errorWith(part([&](auto& each) { each["bodies"][0].erase(name); })),
                HasSubstr(std::string("'") + name + "' of body 1 of part 2 must be"));
  }
  EXPECT_THAT(errorWith(part([](auto& each) {
                each["slabs"] = each["bodies"][0]["slabs"] = std::uint64_t{1} << 40U;
              })),
              HasSubstr("slabs in a file of"));
  EXPECT_THAT(errorWith(part([](auto& each) { each["bodies"][0]["cells"] = 1e30; })),
              HasSubstr("a whole number from 0 to"));
  EXPECT_THAT(errorWith(part([](auto& each) { each["bodies"][0]["cells"] = 1ULL << 41U; })),
              HasSubstr("more than the"));
  EXPECT_THAT(errorWith(part([](auto& each) { each["bodies"][0]["shared"] = 1 << 20U; })),
              HasSubstr("shares"));
  EXPECT_THAT(errorOf(writeFile("text.t4dm", "nothing")), HasSubstr("text.t4dm: is not JSON"));
  EXPECT_THAT(errorOf(writeFile("text.t4dm", platform::contents(parts_[0]))),
              HasSubstr("is a .t4d file, not a manifest"));
  EXPECT_THAT(errorOf(writeFile("cube.t4d", text_)), HasSubstr("is not a .t4d file"));
  EXPECT_THAT(errorOf(manifest_, T4dOpen::FromFront), HasSubstr("read the parts one by one"));
  EXPECT_THAT(T4dSalvage::open(manifest_).error().text(), HasSubstr("is a file in parts"));
  // The contents of a part must agree with the manifest.
  const auto wrong = T4dReader::open(changed(part([](auto& each) {
    each["bodies"][0]["vertices"] = each["bodies"][0]["vertices"].template get<int>() + 1;
  })));
  ASSERT_TRUE(wrong);
  EXPECT_THAT(wrong->body(0).slab(wrong->body(0).slabCount() / 2 - 1).error().text(),
              HasSubstr("piece2.t4d: is not the part that"));
}

TEST_F(FileInParts, RefusesToDescribePartsThatDoNotFit) {
  const auto errorOfParts = [&](const std::vector<std::filesystem::path>& parts) {
    const auto path = temporaryPath("never.t4dm");
    const auto written = writeManifest(parts, path);
    EXPECT_FALSE(std::filesystem::exists(path));
    return written ? std::string() : written.error().text();
  };
  EXPECT_THAT(errorOfParts({parts_[0], parts_[2]}), HasSubstr("cannot be joined after"));
  EXPECT_THAT(errorOfParts({swept("plain.t4d", {1, kParts}, {.index = false})}),
              HasSubstr("plain.t4d: has no index"));
  EXPECT_THAT(errorOfParts({parts_[0], swept("rounded.t4d", {2, kParts}, {.float32 = true})}),
              HasSubstr("stored in the same way"));
  const auto below = parts_[0].parent_path() / "below" / "never.t4dm";
  EXPECT_THAT(writeManifest(parts_, below).error().text(), HasSubstr("is not in the folder of"));
}

#ifdef T4D_WITH_CURL
TEST_F(FileInParts, IsReadFromAWebServer) {
  WebServer server(manifest_.parent_path());
  const auto reader = T4dReader::open(server.url("plain/cube.t4dm"));
  ASSERT_TRUE(reader) << reader.error().text();
  EXPECT_TRUE(slice::sliceAtTime(reader->body(0), 1.15));
  EXPECT_EQ(server.requests("plain/piece1").size() + server.requests("plain/piece3").size(), 0U);
  EXPECT_GE(server.requests("plain/piece2").size(), 1U);
  const auto joined = temporaryPath("fetched.t4d");
  ASSERT_TRUE(joinT4d({server.url("plain/cube.t4dm")}, joined));
  EXPECT_TRUE(checkT4dFile(joined));
}
#endif

}  // namespace
}  // namespace t4d::formats
