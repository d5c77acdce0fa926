#include "tools/t4d/recover.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fixtures/fields.h"
#include "fixtures/solids.h"
#include "formats/t4d/optional_chunks.h"
#include "formats/t4d/test_slabs.h"
#include "t4d/convert.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

/// What is saved from a damaged file is a valid file: closed and oriented, with the hypervolume and
/// the slices of the slabs saved.
namespace t4d::tools {
namespace {

using formats::T4dReader;
using formats::temporaryPath;

constexpr double kRelative = 1e-9;

/// A file of one body, and what was written to it.
struct Written {
  std::string bytes;
  model::Mesh mesh;
  double hypervolume = 0;
};

Written written(const std::function<void(model::Sink&)>& make) {
  Written file;
  make(file.mesh);
  const std::vector<model::Slab> slabs(file.mesh.slabs().begin(), file.mesh.slabs().end());
  file.bytes = platform::contents(formats::writeT4d("original.t4d", {slabs}));
  file.hypervolume = measure::checkMesh(file.mesh)->hypervolume;
  return file;
}

/// A cube that turns about an axis outside of it.
constexpr std::uint64_t kSteps = 24;
constexpr double kDegrees = 180;
Written sweptCube() {
  model::Screw screw;
  screw.axisPoint = {30, 4, 0};
  screw.axisDirection = {1, 2, 3};
  screw.angleDegrees = kDegrees;
  const model::ScrewRun run{kSteps, screw, 1};
  const auto motion = *model::chainScrews(0, {&run, 1});
  return written([&](model::Sink& sink) {
    const auto report = mesh4d::sweep(
        fixtures::cube(20), motion,
        {mesh4d::StepsPerSegment{kSteps}, mesh4d::CapMethod::Cone, mesh4d::PrismSplit::Fourteen},
        sink);
    EXPECT_TRUE(report) << report.error().text();
  });
}

Written wovenSpheres() {
  const fixtures::Field field = fixtures::mergingSpheres(5);
  return written([&](model::Sink& sink) {
    const auto frames = voxel4d::sampledFrames(
        field.value, {}, field.box, model::evenTimes({field.timeBegin, field.timeEnd}, 17),
        {.slope = 1});
    const auto report = voxel4d::weave(*frames, {}, sink);
    EXPECT_TRUE(report) << report.error().text();
  });
}

/// Recovers `bytes` and holds what comes out against what it was. Returns the hypervolume; nothing
/// where nothing was saved.
std::optional<double> recovered(Written& original, const std::string& bytes,
                                RecoverReport* into = nullptr) {
  const auto output = temporaryPath("recovered.t4d");
  std::filesystem::remove(output);
  auto report = recover(formats::writeFile("broken.t4d", bytes), output);
  EXPECT_TRUE(report) << report.error().text();
  if (!report) return std::nullopt;
  if (into != nullptr) *into = *report;
  EXPECT_EQ(report->validation.has_value(), report->slabsSaved > 0);
  EXPECT_EQ(std::filesystem::exists(output), report->slabsSaved > 0);
  if (!report->validation) return std::nullopt;
  EXPECT_TRUE(report->validation->valid()) << report->validation->issues.issues.front().message;

  auto reader = T4dReader::open(output);
  EXPECT_TRUE(reader) << reader.error().text();
  const model::Source& body = reader->body(0);
  // The slabs saved, in order, with caps between them.
  std::size_t next = 0;
  std::uint64_t saved = 0;
  std::mt19937 random(5);
  for (std::size_t i = 0; i < body.slabCount(); ++i) {
    const model::Slab slab = **body.slab(i);
    std::size_t at = next;
    const auto slabs = original.mesh.slabs();
    while (at < slabs.size() && !formats::same(slabs[at], slab)) ++at;
    if (at == slabs.size()) {
      EXPECT_EQ(slab.timeBegin, slab.timeEnd) << "neither a slab of the original nor a cap";
      continue;
    }
    next = at + 1;
    ++saved;
    if (slab.timeBegin == slab.timeEnd) continue;
    for (const double s : {0.0, std::uniform_real_distribution<double>(0, 1)(random)}) {
      const double time = slab.timeBegin + s * (slab.timeEnd - slab.timeBegin);
      const auto found = slice::sliceAtTime(body, time);
      const auto expected = slice::sliceAtTime(original.mesh, time);
      EXPECT_TRUE(found && expected);
      EXPECT_EQ(found->mesh.vertices, expected->mesh.vertices);
      EXPECT_EQ(found->mesh.triangles, expected->mesh.triangles);
      EXPECT_EQ(found->mesh.attributes, expected->mesh.attributes);
    }
  }
  EXPECT_EQ(saved, report->slabsSaved);
  return report->validation->mesh->hypervolume;
}

TEST(Recover, AWholeFileLosesNothing) {
  for (Written original : {sweptCube(), wovenSpheres()}) {
    RecoverReport report;
    const auto hypervolume = recovered(original, original.bytes, &report);
    EXPECT_TRUE(report.lost.empty());
    EXPECT_TRUE(report.closed.empty());
    EXPECT_TRUE(report.metadataSaved);
    EXPECT_EQ(report.slabsSaved, original.mesh.slabs().size());
    EXPECT_EQ(report.slabsKnown, original.mesh.slabs().size());
    EXPECT_NEAR(*hypervolume, original.hypervolume, original.hypervolume * kRelative);
  }
}

TEST(Recover, ListsTheCapsOfAMeshThatWasOpen) {
  const Written original = sweptCube();
  const auto slabs = original.mesh.slabs();
  const std::vector<model::Slab> open(slabs.begin(), slabs.end() - 1);  // without its end cap
  const auto input = formats::writeT4d("open.t4d", {open});
  const auto report = recover(input, temporaryPath("recovered.t4d"));
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->slabsSaved, open.size());
  ASSERT_EQ(report->closed.size(), 1U);
  ASSERT_EQ(report->lost.size(), 1U);
  EXPECT_THAT(report->lost[0].what,
              testing::HasSubstr("was open where it ends at time 24; a cap was added there"));
  EXPECT_TRUE(report->validation->valid());
}

TEST(Recover, ListsWhatIsLostInTheOrderOfTheFile) {
  // A chunk at the front that may not be copied, and a slab that is damaged.
  const Written original = sweptCube();
  const std::vector<model::Slab> slabs(original.mesh.slabs().begin(), original.mesh.slabs().end());
  std::string bytes = platform::contents(formats::writeT4d("plain.t4d", {slabs}, {.index = false}));
  formats::t4d_layout::PayloadWriter payload;
  payload.putBytes("text", 4);
  auto [header, front] = formats::frontOf({'a', 'c', 'm', 'E'}, payload, 0, 0);
  ASSERT_FALSE(formats::isSafeToCopy(header.type));
  const auto encoded = formats::encodeChunkHeader(header);
  front.pad();
  std::string chunk(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  chunk.append(reinterpret_cast<const char*>(front.data()), front.size());
  bytes.insert(formats::listChunks(bytes).front().end(), chunk);
  formats::repairChecksums(bytes);
  std::vector<formats::ChunkHeader> chunks = formats::listChunks(bytes);
  std::erase_if(chunks, [](const auto& one) { return one.name() != "SLAB"; });
  const formats::ChunkHeader& damaged = chunks[chunks.size() / 2];
  bytes[damaged.payload() + damaged.payloadBytes / 2] ^= 0x20;
  const auto report =
      recover(formats::writeFile("broken.t4d", bytes), temporaryPath("recovered.t4d"));
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_GE(report->lost.size(), 2U);
  EXPECT_THAT(report->lost[0].what, testing::HasSubstr("acmE"));
  for (std::size_t i = 1; i < report->lost.size(); ++i) {
    EXPECT_LE(report->lost[i - 1].offset, report->lost[i].offset);
  }
}

TEST(Recover, BeginningOfASweepHasTheHypervolumeOfTheLaw) {
  Written original = sweptCube();
  std::mt19937 random(6);
  const double theta = kDegrees / kSteps * std::numbers::pi / 180;
  for (int i = 0; i < 50; ++i) {
    const std::size_t length = random() % original.bytes.size();
    SCOPED_TRACE(length);
    RecoverReport report;
    const std::string bytes = original.bytes.substr(0, length);
    if (length < 24) {
      EXPECT_FALSE(recover(formats::writeFile("broken.t4d", bytes), temporaryPath("none.t4d")));
      continue;
    }
    const auto hypervolume = recovered(original, bytes, &report);
    EXPECT_FALSE(report.lost.empty());
    if (!hypervolume) continue;
    // The start cap, and steps.
    const auto steps = static_cast<double>(std::min(report.slabsSaved - 1, kSteps));
    EXPECT_NEAR(*hypervolume, steps * 8000 * (2 + std::cos(theta)) / 3,
                original.hypervolume * kRelative);
    EXPECT_EQ(report.closed.size(), report.slabsSaved < kSteps + 2 ? 1U : 0U);
  }
}

TEST(Recover, BeginningOfAWovenMeshIsValid) {
  Written original = wovenSpheres();
  std::mt19937 random(7);
  double before = 0;
  std::vector<std::size_t> lengths(50);
  for (std::size_t& length : lengths) length = 24 + random() % (original.bytes.size() - 24);
  std::sort(lengths.begin(), lengths.end());
  for (const std::size_t length : lengths) {
    SCOPED_TRACE(length);
    const double hypervolume = recovered(original, original.bytes.substr(0, length)).value_or(0);
    EXPECT_GE(hypervolume, before * (1 - kRelative));
    before = hypervolume;
  }
}

TEST(Recover, LosesOneSlabWhereOneIsDamagedAndTheRestIsExact) {
  for (Written original : {sweptCube(), wovenSpheres()}) {
    for (const formats::ChunkHeader& chunk : formats::listChunks(original.bytes)) {
      if (chunk.name() != "SLAB") continue;
      SCOPED_TRACE(chunk.offset);
      std::string bytes = original.bytes;
      bytes[chunk.payload() + chunk.payloadBytes / 2] ^= 0x20;
      RecoverReport report;
      const auto rest = recovered(original, bytes, &report);
      EXPECT_EQ(report.slabsSaved + 1, original.mesh.slabs().size());
      ASSERT_EQ(report.lost.size(), 1U);
      EXPECT_EQ(report.lost[0].offset, chunk.offset);
      ASSERT_TRUE(report.lost[0].time);
      // The lost slab, closed by itself.
      model::Mesh alone;
      edit::RunCloser closer(alone);
      for (const model::Slab& slab : original.mesh.slabs()) {
        if (slab.timeBegin == report.lost[0].time->begin &&
            slab.timeEnd == report.lost[0].time->end) {
          ASSERT_TRUE(closer.put(slab));
        }
      }
      ASSERT_TRUE(closer.finish());
      EXPECT_NEAR(*rest + measure::checkMesh(alone)->hypervolume, original.hypervolume,
                  original.hypervolume * kRelative);
    }
  }
}

TEST(Recover, KeepsTheMetadataAndSaysWhereItComesFrom) {
  const Written original = sweptCube();
  const auto output = temporaryPath("recovered.t4d");
  const auto input =
      formats::writeFile("broken.t4d", original.bytes.substr(0, original.bytes.size() / 2));
  const auto report = recover(input, output, {.generator = "us"});
  ASSERT_TRUE(report);
  const formats::Metadata metadata = T4dReader::open(output)->metadata();
  EXPECT_THAT(metadata.bodies,
              testing::ElementsAre(testing::Field(&formats::BodyInfo::name, "body 0")));
  EXPECT_EQ(metadata.generator, "us");
  const auto note = nlohmann::json::parse(metadata.detailsJson)["recovered"];
  EXPECT_EQ(note["from"], input.filename().string());
  EXPECT_EQ(note["generator"], "test");
  EXPECT_EQ(note["slabs_saved"], report->slabsSaved);
  EXPECT_FALSE(note.contains("slabs_known"));
  EXPECT_TRUE(note["gaps"].empty());
}

TEST(Recover, SlabsOfNoClosedMeshAreWrittenAllTheSame) {
  std::mt19937 random(8);
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<std::vector<model::Slab>> bodies = {formats::RandomSlabs(seed).make(6),
                                                          formats::RandomSlabs(seed + 500).make(4)};
    std::string bytes = platform::contents(formats::writeT4d("original.t4d", bodies));
    const std::size_t at = 24 + random() % (bytes.size() - 24);
    if (seed % 2 == 0) {
      bytes.resize(at);
    } else {
      bytes[at] ^= 0x10;
    }
    const auto output = temporaryPath("recovered.t4d");
    std::filesystem::remove(output);
    const auto report = recover(formats::writeFile("broken.t4d", bytes), output);
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_FALSE(report->lost.empty());
    if (report->slabsSaved == 0) continue;
    const auto checked = formats::checkT4dFile(output);
    EXPECT_TRUE(checked) << checked.error().text();
    // All slabs are there.
    auto reader = T4dReader::open(output);
    ASSERT_TRUE(reader);
    std::uint64_t found = 0;
    for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
      for (std::size_t k = 0; k < reader->body(i).slabCount(); ++k) {
        const model::Slab slab = **reader->body(i).slab(k);
        for (const auto& body : bodies) {
          for (const model::Slab& one : body) found += formats::same(one, slab) ? 1 : 0;
        }
      }
    }
    EXPECT_EQ(found, report->slabsSaved);
  }
}

}  // namespace
}  // namespace t4d::tools
