#include "formats/t4d/merge.h"

#include <gmock/gmock.h>

#include "fixtures/solids.h"
#include "formats/t4d/body_details.h"
#include "formats/t4d/test_slabs.h"
#include "t4d/check.h"
#include "t4d/sweep.h"

namespace t4d::formats {
namespace {

using testing::HasSubstr;

/// Two cubes that move, as bodies of one file.
std::filesystem::path sweptFile(const std::string& name, Metadata metadata, double size,
                                const T4dWriteOptions& options = {}) {
  const auto path = temporaryPath(name);
  model::ScrewRun run;
  run.duration = size;
  run.screw.translation = {size, 0, 0};
  auto writer = T4dWriter::create(path, metadata, options);
  EXPECT_TRUE(writer) << writer.error().text();
  for (std::size_t i = 0; i < metadata.bodies.size(); ++i) {
    const auto report =
        mesh4d::sweep(fixtures::cube(size + static_cast<double>(i)),
                      *model::chainScrews(0, std::span(&run, 1)), {}, writer->body(i));
    EXPECT_TRUE(report) << report.error().text();
  }
  EXPECT_TRUE(writer->finish());
  return path;
}

std::vector<model::Slab> slabsOf(const T4dReader& reader, std::size_t body) {
  std::vector<model::Slab> slabs;
  for (std::size_t i = 0; i < reader.body(body).slabCount(); ++i) {
    slabs.push_back(**reader.body(body).slab(i));
  }
  return slabs;
}

TEST(Merge, BodiesOfAllFilesAreThoseOfTheFiles) {
  const T4dWriteOptions ways[] = {T4dWriteOptions{}, T4dWriteOptions{.float32 = true},
                                  T4dWriteOptions{.compression = 0, .index = false},
                                  T4dWriteOptions{.step = 0.001}, T4dWriteOptions{.spareEvery = 2}};
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < std::size(ways); ++i) {
    files.push_back(sweptFile(std::to_string(i) + ".t4d",
                              metadataOf({"a" + std::to_string(i), "b" + std::to_string(i)}),
                              1.0 + static_cast<double>(i), ways[i]));
  }
  const auto path = temporaryPath("merged.t4d");
  const auto merged = mergeT4d(files, path);
  ASSERT_TRUE(merged) << merged.error().text();
  EXPECT_THAT(merged->notices, testing::IsEmpty());
  EXPECT_THAT(merged->losses, testing::IsEmpty());
  EXPECT_EQ(merged->bytes, std::filesystem::file_size(path));
  const auto checked = checkT4dFile(path);
  ASSERT_TRUE(checked) << checked.error().text();
  EXPECT_EQ(streamFaultOf(path), "");
  const auto reader = T4dReader::open(path, T4dOpen::Checked);
  ASSERT_TRUE(reader) << reader.error().text();
  ASSERT_EQ(reader->metadata().bodies.size(), 2 * files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto original = T4dReader::open(files[i]);
    ASSERT_TRUE(original);
    for (std::size_t body : {0, 1}) {
      const std::size_t into = 2 * i + body;
      EXPECT_EQ(reader->metadata().bodies[into].name, original->metadata().bodies[body].name);
      EXPECT_EQ(merged->bodies[into].file, i);
      EXPECT_EQ(reader->summary(into).vertices, original->summary(body).vertices);
      const auto found = slabsOf(*reader, into);
      const auto wanted = slabsOf(*original, body);
      ASSERT_EQ(found.size(), wanted.size());
      for (std::size_t k = 0; k < found.size(); ++k) EXPECT_TRUE(same(found[k], wanted[k]));
      const auto report = measure::checkMesh(reader->body(into));
      ASSERT_TRUE(report) << report.error().text();
      EXPECT_TRUE(report->closed && report->oriented);
    }
  }
}

TEST(Merge, NamesBecomeUniqueAndParentsFollow) {
  Metadata metadata = metadataOf({"arm", "hand"});
  metadata.bodies[1].parent = "arm";
  setLink(metadata.bodies[1], "arm");
  metadata.backend = "mesh4d";
  metadata.detailsJson = R"({"source":{"mesh":"arm.obj"}})";
  const auto file = sweptFile("robot.t4d", metadata, 1);
  const auto path = temporaryPath("merged.t4d");
  const auto merged = mergeT4d({file, file, file}, path);
  ASSERT_TRUE(merged) << merged.error().text();
  const auto reader = T4dReader::open(path);
  ASSERT_TRUE(reader);
  std::vector<std::string> names;
  for (const BodyInfo& body : reader->metadata().bodies) names.push_back(body.name);
  EXPECT_THAT(names, testing::ElementsAre("arm", "hand", "arm 2", "hand 2", "arm 3", "hand 3"));
  EXPECT_EQ(reader->metadata().bodies[5].parent, "arm 3");
  EXPECT_EQ(linkOf(reader->metadata().bodies[1]), "arm");
  EXPECT_EQ(linkOf(reader->metadata().bodies[5]), "arm 3");
  EXPECT_EQ(merged->notices.size(), 4U);
  EXPECT_THAT(merged->notices[0], HasSubstr("the body 'arm' is named 'arm 2'"));
  EXPECT_EQ(reader->metadata().backend, "mesh4d");
  EXPECT_THAT(reader->metadata().detailsJson, HasSubstr("arm.obj"));
}

TEST(Merge, RefusesFilesThatDoNotFit) {
  Metadata metadata = metadataOf({"a"});
  metadata.lengthUnit = "mm";
  metadata.timeUnit = "s";
  const auto first = sweptFile("first.t4d", metadata, 1, {.step = 0.001});
  const auto path = temporaryPath("merged.t4d");
  std::filesystem::remove(path);
  const auto errorWith = [&](const std::filesystem::path& other) {
    const auto merged = mergeT4d({first, other}, path);
    EXPECT_FALSE(std::filesystem::exists(path));
    return merged ? std::string("(was merged)") : merged.error().text();
  };
  const auto changed = [&](auto change) {
    Metadata other = metadata;
    change(other);
    return sweptFile("other.t4d", other, 1);
  };
  EXPECT_THAT(errorWith(changed([](Metadata& m) { m.lengthUnit = "m"; })),
              HasSubstr("other.t4d: cannot be merged: its unit of length is m, and that of"));
  EXPECT_THAT(errorWith(changed([](Metadata& m) { m.timeUnit = ""; })),
              HasSubstr("unit of time is unknown"));
  EXPECT_THAT(errorWith(changed([](Metadata& m) { m.up = "z"; })), HasSubstr("upward axis is z"));
  EXPECT_THAT(errorWith(changed([](Metadata& m) { m.space = "RAS"; })), HasSubstr("space is RAS"));
  EXPECT_THAT(errorWith(sweptFile("grid.t4d", metadata, 1, {.step = 0.01})), HasSubstr("grid"));
  std::string damaged = platform::contents(first);
  damaged[damaged.size() / 2] ^= 1;
  EXPECT_THAT(errorWith(writeFile("damaged.t4d", damaged)), HasSubstr("damaged.t4d: byte"));
  const auto none = mergeT4d({}, path);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().text(), HasSubstr("no file"));
}

}  // namespace
}  // namespace t4d::formats
