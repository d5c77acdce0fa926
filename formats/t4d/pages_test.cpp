#include "formats/t4d/pages.h"

#include <gmock/gmock.h>

#include "fixtures/solids.h"
#include "formats/t4d/chunk_list.h"
#include "formats/t4d/join.h"
#include "formats/t4d/salvage.h"
#include "formats/t4d/test_slabs.h"
#include "model/slab_groups.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#ifdef T4D_WITH_CURL
#include "tests/web_server.h"
#endif

namespace t4d::formats {
namespace {

using testing::HasSubstr;

constexpr std::size_t kPageSlabs = 64;
/// Uncompressed, their index is large enough for pages to be looked for.
constexpr int kSlabs = 2500;
constexpr T4dWriteOptions kPaged{.compression = 0, .pageSlabs = kPageSlabs};
constexpr T4dWriteOptions kWhole{.compression = 0, .pageSlabs = kSlabs};

/// A bipyramid that turns about an axis.
std::filesystem::path swept(const std::string& name, const T4dWriteOptions& options,
                            const model::Part& part = {1, 1}) {
  const auto path = temporaryPath(name);
  auto writer = T4dWriter::create(path, metadataOf({"solid"}), options);
  model::ScrewRun run;
  run.duration = 1;
  run.screw.axisDirection = {0, 0, 1};
  run.screw.angleDegrees = 720;
  run.screw.translation = {0, 0, 5};
  mesh4d::SweepOptions how;
  how.steps = mesh4d::StepsPerSegment{kSlabs};
  how.part = part;
  const auto motion = *model::chainScrews(0, std::span(&run, 1));
  EXPECT_TRUE(mesh4d::sweep(fixtures::bipyramid(3), motion, how, writer->body(0)));
  EXPECT_TRUE(writer->finish());
  return path;
}

std::vector<ChunkHeader> pagesOf(const std::string& bytes) {
  std::vector<ChunkHeader> pages;
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    if (chunk.type == t4d_layout::kPage) pages.push_back(chunk);
  }
  return pages;
}

void expectTheSame(const T4dReader& a, const T4dReader& b) {
  ASSERT_EQ(a.bodyCount(), b.bodyCount());
  for (std::size_t body = 0; body < a.bodyCount(); ++body) {
    const model::Source& of = a.body(body);
    const model::Source& other = b.body(body);
    ASSERT_EQ(of.slabCount(), other.slabCount());
    for (std::size_t i = 0; i < of.slabCount(); ++i) {
      EXPECT_EQ(of.timeSpan(i).begin, other.timeSpan(i).begin);
      EXPECT_EQ(of.timeSpan(i).end, other.timeSpan(i).end);
      EXPECT_EQ(of.cellCount(i), other.cellCount(i));
      EXPECT_TRUE(same(**of.slab(i), **other.slab(i))) << i;
    }
  }
}

TEST(Pages, SayWhatTheIndexSays) {
  RandomSlabs random(7);
  std::vector<std::vector<model::Slab>> bodies;
  for (const int count : {kSlabs, 3, kSlabs / 2}) bodies.push_back(random.make(count));
  const auto paged = T4dReader::open(writeT4d("paged.t4d", bodies, kPaged));
  const auto whole = T4dReader::open(writeT4d("whole.t4d", bodies, kWhole));
  ASSERT_TRUE(paged) << paged.error().text();
  ASSERT_TRUE(whole) << whole.error().text();
  EXPECT_FALSE(model::slabGroupsOf(paged->body(0)).empty());
  EXPECT_TRUE(model::slabGroupsOf(whole->body(0)).empty());
  expectTheSame(*paged, *whole);
  EXPECT_EQ(faultOf(temporaryPath("paged.t4d"), T4dOpen::Checked), "");
  EXPECT_EQ(streamFaultOf(temporaryPath("paged.t4d")), "");
}

TEST(Pages, AreFoundInAMeshThatIsValid) {
  const auto path = swept("paged.t4d", kPaged);
  EXPECT_EQ(pagesOf(platform::contents(path)).size(), (kSlabs + 2 + kPageSlabs - 1) / kPageSlabs);
  ASSERT_TRUE(checkT4dFile(path));
  const auto reader = T4dReader::open(path);
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->version().minor, 1);
  const auto report = measure::checkMesh(reader->body(0));
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(report->closed && report->oriented);
}

TEST(Pages, AreLeftOutOfSmallFilesAndKeepTheirVersion) {
  const auto path = swept("whole.t4d", kWhole);
  EXPECT_TRUE(pagesOf(platform::contents(path)).empty());
  EXPECT_EQ(T4dReader::open(path)->version().minor, 0);
}

TEST(Pages, ASliceReadsOneOfThem) {
  const auto path = swept("paged.t4d", kPaged);
  const auto reader = T4dReader::open(path);
  ASSERT_TRUE(reader);
  const std::uint64_t opened = reader->bytesRead();
  ASSERT_TRUE(slice::sliceAtTime(reader->body(0), 0.6003));
  const std::vector<ChunkHeader> pages = pagesOf(platform::contents(path));
  EXPECT_LT(reader->bytesRead() - opened, 2 * pages.front().bytes());
}

TEST(Pages, AreMadeAnewByJoin) {
  const std::vector<std::filesystem::path> parts = {swept("first.t4d", kPaged, {1, 2}),
                                                    swept("second.t4d", kPaged, {2, 2})};
  const auto joined = temporaryPath("joined.t4d");
  ASSERT_TRUE(joinT4d(parts, joined));
  // There are too few slabs for pages of the usual size.
  EXPECT_TRUE(pagesOf(platform::contents(joined)).empty());
  ASSERT_TRUE(checkT4dFile(joined));
  expectTheSame(*T4dReader::open(joined), *T4dReader::open(swept("whole.t4d", kWhole)));
}

TEST(Pages, AreRefusedWhereTheyAreWrong) {
  const auto path = swept("paged.t4d", kPaged);
  const std::string bytes = platform::contents(path);
  const std::vector<ChunkHeader> pages = pagesOf(bytes);
  const ChunkHeader list = listChunks(bytes).rbegin()[2];
  ASSERT_EQ(list.type, t4d_layout::kPageList);
  for (const ChunkHeader& chunk : {pages[0], pages.back(), list}) {
    for (std::uint64_t at = chunk.offset; at < chunk.end(); at += 199) {
      std::string changed = bytes;
      changed[at] ^= 1;
      const auto path = writeFile("changed.t4d", changed);
      EXPECT_THAT(faultOf(path, T4dOpen::Checked), HasSubstr("byte")) << at - chunk.offset;
      // What is no list of pages is not looked at: the index has all that is needed.
      if (at != list.offset) {
        EXPECT_THAT(faultOf(path), HasSubstr("byte")) << at - chunk.offset;
      }
      // What a page says must be so, and not only have its checksum.
      repairChecksums(changed);
      if (changed == bytes) continue;
      writeFile("changed.t4d", changed);
      EXPECT_THAT(faultOf(path, T4dOpen::Checked), HasSubstr("byte")) << at - chunk.offset;
    }
  }
}

TEST(Pages, AreNotNeededToRecoverAFile) {
  const auto path = swept("paged.t4d", kPaged);
  std::string bytes = platform::contents(path);
  bytes[pagesOf(bytes)[3].offset + 100] ^= 1;
  const auto salvage = T4dSalvage::open(writeFile("changed.t4d", bytes));
  ASSERT_TRUE(salvage) << salvage.error().text();
  EXPECT_EQ(salvage->body(0).slabCount(), kSlabs + 2U);
}

#ifdef T4D_WITH_CURL
TEST(Pages, ASliceTakesFiveRequests) {
  const auto path = swept("paged.t4d", kPaged);
  const auto here = slice::sliceAtTime(T4dReader::open(path)->body(0), 0.6003);
  WebServer server(path.parent_path());
  const auto reader = T4dReader::open(server.url("plain/paged.t4d"));
  ASSERT_TRUE(reader) << reader.error().text();
  const auto there = slice::sliceAtTime(reader->body(0), 0.6003);
  ASSERT_TRUE(there) << there.error().text();
  EXPECT_EQ(there->mesh.vertices, here->mesh.vertices);
  EXPECT_LE(server.requests("plain/paged").size(), 5U);
  EXPECT_EQ(server.requests("plain/paged").size(), reader->requests());
}
#endif

}  // namespace
}  // namespace t4d::formats
