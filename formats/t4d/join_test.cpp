#include "formats/t4d/join.h"

#include <gmock/gmock.h>

#include "fixtures/solids.h"
#include "formats/t4d/test_slabs.h"
#include "t4d/check.h"
#include "t4d/sweep.h"

namespace t4d::formats {
namespace {

using testing::HasSubstr;

model::Motion quarterTurn() {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.axisDirection = {0, 0, 1};
  run.screw.angleDegrees = 90;
  run.screw.translation = {0, 0, 0.3};
  return *model::chainScrews(0.7, std::span(&run, 1));
}

/// A part of a sweep.
std::filesystem::path sweptPart(const std::string& name, const model::Part& part,
                                const T4dWriteOptions& options = {}, double size = 1) {
  const auto path = temporaryPath(name);
  auto writer = T4dWriter::create(path, metadataOf({"cube"}), options);
  EXPECT_TRUE(writer) << writer.error().text();
  mesh4d::SweepOptions how;
  how.steps = mesh4d::StepsPerSegment{11};
  how.part = part;
  const auto report = mesh4d::sweep(fixtures::cube(size), quarterTurn(), how, writer->body(0));
  EXPECT_TRUE(report) << report.error().text();
  EXPECT_TRUE(writer->finish());
  return path;
}

std::vector<model::Slab> slabsIn(const std::filesystem::path& path) {
  std::vector<model::Slab> slabs;
  const auto reader = T4dReader::open(path, T4dOpen::Checked);
  EXPECT_TRUE(reader) << reader.error().text();
  for (std::size_t i = 0; i < reader->body(0).slabCount(); ++i) {
    slabs.push_back(**reader->body(0).slab(i));
  }
  return slabs;
}

TEST(Join, PartsOfASweepAreTheSweep) {
  for (const T4dWriteOptions& options :
       {T4dWriteOptions{}, T4dWriteOptions{.float32 = true}, T4dWriteOptions{.step = 0.001},
        T4dWriteOptions{.compression = 0, .index = false}, T4dWriteOptions{.spareEvery = 2}}) {
    const std::vector<model::Slab> whole = slabsIn(sweptPart("whole.t4d", {1, 1}, options));
    for (const std::uint64_t count : {2, 3, 11}) {
      std::vector<std::filesystem::path> parts;
      for (std::uint64_t i = 1; i <= count; ++i) {
        parts.push_back(sweptPart("part" + std::to_string(i) + ".t4d", {i, count}, options));
      }
      const auto path = temporaryPath("joined.t4d");
      const auto joined = joinT4d(parts, path);
      ASSERT_TRUE(joined) << joined.error().text();
      EXPECT_EQ(joined->bytes, std::filesystem::file_size(path));
      const auto checked = checkT4dFile(path);
      ASSERT_TRUE(checked) << checked.error().text();
      EXPECT_EQ(streamFaultOf(path), "");
      const std::vector<model::Slab> slabs = slabsIn(path);
      ASSERT_EQ(slabs.size(), whole.size());
      for (std::size_t i = 0; i < slabs.size(); ++i) {
        // Poses are rounded otherwise than layers, which are where parts meet.
        EXPECT_TRUE(options.float32 || options.step || same(slabs[i], whole[i])) << i;
      }
      const auto reader = T4dReader::open(path);
      EXPECT_EQ(reader->summary(0).vertices, joined->bodies[0].vertices);
      const auto report = measure::checkMesh(reader->body(0));
      ASSERT_TRUE(report) << report.error().text();
      EXPECT_TRUE(report->closed && report->oriented);
      EXPECT_EQ(report->vertices, joined->bodies[0].vertices);
    }
  }
}

TEST(Join, StoresLayersAtSeamsAndSharedConnectivitiesOnce) {
  const auto countOf = [](const std::filesystem::path& path, const std::string& type) {
    const std::vector<ChunkHeader> chunks = listChunks(platform::contents(path));
    return std::ranges::count(chunks, type, &ChunkHeader::name);
  };
  const std::vector<std::filesystem::path> parts = {
      sweptPart("a.t4d", {1, 3}), sweptPart("b.t4d", {2, 3}), sweptPart("c.t4d", {3, 3})};
  const auto path = temporaryPath("joined.t4d");
  ASSERT_TRUE(joinT4d(parts, path));
  for (const auto& [type, twice] : {std::pair("CONN", 2), std::pair("LAYR", 2)}) {
    std::ptrdiff_t all = -twice;  // what the second part and the third have of those before them
    for (const auto& part : parts) all += countOf(part, type);
    EXPECT_EQ(countOf(path, type), all) << type;
  }
}

TEST(Join, PartsOfAnySlabsAreTheBytesOfOneFile) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const std::vector<model::Slab> slabs = RandomSlabs(seed).make(40);
    const std::string whole = platform::contents(writeT4d("whole.t4d", {slabs}));
    for (const std::size_t count : {2, 5, 40}) {
      std::vector<std::filesystem::path> parts;
      for (std::size_t i = 0; i < count; ++i) {
        const model::PartRange own = model::Part{i + 1, count}.of(slabs.size());
        const auto at = [&](std::uint64_t k) { return slabs.begin() + std::ptrdiff_t(k); };
        parts.push_back(writeT4d("part" + std::to_string(i) + ".t4d",
                                 {std::vector(at(own.begin), at(own.end))}));
      }
      const auto path = temporaryPath("joined.t4d");
      const auto joined = joinT4d(parts, path);
      ASSERT_TRUE(joined) << joined.error().text();
      EXPECT_TRUE(platform::contents(path) == whole) << seed << ", in " << count;
    }
  }
}

TEST(Join, PutsSolidsOneAfterAnother) {
  model::Slab laterSimplex = simplexSlab();
  for (model::Point4& vertex : laterSimplex.vertices) vertex[3] += 5;
  laterSimplex.timeBegin += 5;
  laterSimplex.timeEnd += 5;
  const std::vector<std::filesystem::path> parts = {writeT4d("a.t4d", {{simplexSlab()}}),
                                                    writeT4d("b.t4d", {{laterSimplex}})};
  const auto path = temporaryPath("joined.t4d");
  const auto done = joinT4d(parts, path);
  ASSERT_TRUE(done) << done.error().text();
  const auto checked = checkT4dFile(path);
  EXPECT_TRUE(checked) << checked.error().text();
}

TEST(Join, RefusesPartsThatDoNotMeet) {
  const auto first = sweptPart("first.t4d", {1, 3});
  const auto second = sweptPart("second.t4d", {2, 3});
  const auto third = sweptPart("third.t4d", {3, 3});
  const auto path = temporaryPath("joined.t4d");
  std::filesystem::remove(path);
  const auto errorOf = [&](const std::vector<std::filesystem::path>& parts) {
    const auto joined = joinT4d(parts, path);
    EXPECT_FALSE(std::filesystem::exists(path));
    return joined ? std::string() : joined.error().text();
  };
  EXPECT_THAT(errorOf({first, third}), HasSubstr("third.t4d: cannot be joined after"));
  EXPECT_THAT(errorOf({first, third}), HasSubstr("the body 'cube' begins at time"));
  EXPECT_THAT(errorOf({second, first}), HasSubstr("begins at time"));
  EXPECT_THAT(errorOf({third, first}), HasSubstr("begins at time"));
  EXPECT_THAT(errorOf({first, sweptPart("larger.t4d", {2, 3}, {}, 2)}),
              HasSubstr("does not begin with the layer"));
  EXPECT_THAT(errorOf({first, sweptPart("single.t4d", {2, 3}, {.float32 = true})}),
              HasSubstr("stored in the same way"));
  EXPECT_THAT(errorOf({first, sweptPart("grid.t4d", {2, 3}, {.step = 0.5})}),
              HasSubstr("the grid of its positions"));
  EXPECT_THAT(errorOf({first, writeT4d("other.t4d", {{simplexSlab()}})}),
              HasSubstr("its bodies are not those"));
  std::string damaged = platform::contents(second);
  damaged[damaged.size() / 2] ^= 1;
  EXPECT_THAT(errorOf({first, writeFile("damaged.t4d", damaged)}), HasSubstr("damaged.t4d: byte"));
  EXPECT_THAT(errorOf({}), HasSubstr("no file"));
  std::string more = platform::contents(sweptPart("plain.t4d", {1, 3}, {.index = false}));
  const auto chunks = listChunks(more);
  const auto done = std::ranges::find(chunks, "DONE", &ChunkHeader::name);
  constexpr std::size_t kCellsOfTheFirstBody = 32;
  more[done->payload() + kCellsOfTheFirstBody] ^= 1;
  repairChecksums(more);
  EXPECT_THAT(errorOf({writeFile("more.t4d", more)}), HasSubstr("DONE: body 0 has"));
}

TEST(Join, SeveralBodiesAndBodiesWithoutLayers) {
  const auto later = [](double by) {
    model::Slab slab = simplexSlab();
    slab.timeBegin += by;
    slab.timeEnd += by;
    for (model::Point4& vertex : slab.vertices) vertex[3] += by;
    return slab;
  };
  const auto path = temporaryPath("joined.t4d");
  const auto joined = joinT4d({writeT4d("a.t4d", {{later(0)}, {later(0), later(1)}}),
                               writeT4d("b.t4d", {{later(3), later(7)}, {later(2)}})},
                              path);
  ASSERT_TRUE(joined) << joined.error().text();
  EXPECT_EQ(joined->bodies[0].slabs, 3U);
  EXPECT_EQ(joined->bodies[1].vertices, 15U);
  EXPECT_EQ(joined->bodies[0].time.end, 8);
  const auto checked = checkT4dFile(path);
  EXPECT_TRUE(checked) << checked.error().text();
}

}  // namespace
}  // namespace t4d::formats
