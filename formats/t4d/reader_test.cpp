#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fixtures/solids.h"
#include "formats/t4d/test_slabs.h"
#include "model/slab_blocks.h"
#include "t4d/file.h"
#include "t4d/sweep.h"

namespace t4d::formats {
namespace {

using model::Slab;
using t4d_layout::PayloadWriter;
using testing::HasSubstr;

/// A small file with two bodies, and what is in it.
struct Sample {
  std::vector<std::vector<Slab>> bodies;
  std::filesystem::path path;
  std::string bytes;
  std::vector<ChunkHeader> chunks;

  Sample(const std::string& name, const T4dWriteOptions& options)
      : bodies{RandomSlabs(3).make(3), RandomSlabs(8).make(2)},
        path(writeT4d(name, bodies, options)),
        bytes(platform::contents(path)),
        chunks(listChunks(bytes)) {}

  const ChunkHeader& chunkAt(std::size_t offset) const {
    for (const ChunkHeader& chunk : chunks) {
      if (chunk.offset == offset) return chunk;
    }
    ADD_FAILURE() << "no chunk at " << offset;
    return chunks.front();
  }
  std::size_t endOf(const std::string& type) const {
    for (const ChunkHeader& chunk : chunks) {
      if (chunk.name() == type) return chunk.end();
    }
    return 0;
  }
  /// The chunks that a slab is made of: its own, its connectivity, its layers.
  std::vector<ChunkHeader> partsOf(std::size_t slabOffset) const {
    const ChunkHeader& slab = chunkAt(slabOffset);
    std::vector<ChunkHeader> parts = {slab};
    for (const std::size_t at : {16, 24, 32}) {
      std::uint64_t distance = 0;
      std::memcpy(&distance, bytes.data() + slab.fields() + at, sizeof distance);
      if (distance != 0) parts.push_back(chunkAt(slabOffset - distance));
    }
    return parts;
  }
};

TEST(T4dReader, ReadsOfTheFileTheBytesOfOneSlabOnly) {
  const Sample sample("lazy.t4d", {});
  for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
    for (std::size_t k = 0; k < sample.bodies[i].size(); ++k) {
      auto reader = T4dReader::open(sample.path);
      ASSERT_TRUE(reader) << reader.error().text();
      // Header, HEAD, end mark, index and footer, each once.
      const std::size_t ends = sample.endOf("HEAD") + sample.bytes.size() -
                               sample.chunks[sample.chunks.size() - 2].offset;
      EXPECT_EQ(reader->bytesRead(), ends);
      ASSERT_TRUE(reader->body(i).slab(k));
      std::size_t parts = 0;
      for (const ChunkHeader& chunk : sample.partsOf(reader->slabOffset(i, k))) {
        parts += chunk.end() - chunk.offset;
      }
      EXPECT_EQ(reader->bytesRead() - ends, parts);
    }
  }
}

TEST(T4dReader, GivesTheSameSlabsToThreadsThatReadAtOnce) {
  const std::vector<std::vector<Slab>> bodies = {RandomSlabs(5).make(40), RandomSlabs(6).make(40)};
  const auto reader = T4dReader::open(writeT4d("threads.t4d", bodies));
  ASSERT_TRUE(reader) << reader.error().text();
  // Each thread goes through the slabs in steps of its own: forward, backward, and leaping.
  const auto readAll = [&](std::size_t step) {
    for (std::size_t n = 0; n < 80; ++n) {
      const std::vector<Slab>& expected = bodies[n % 2];
      const std::size_t k = n / 2 * step % expected.size();
      const auto slab = reader->body(n % 2).slab(k);
      EXPECT_TRUE(slab && same(**slab, expected[k])) << k;
    }
  };
  std::vector<std::jthread> threads;
  for (const std::size_t step : {1, 39, 1, 7}) threads.emplace_back(readAll, step);
}

TEST(T4dReader, SharesTheConnectivityOfSlabsInARow) {
  std::vector<Slab> slabs = RandomSlabs(5).make(40);
  const auto reader = T4dReader::open(writeT4d("shared.t4d", {slabs}));
  ASSERT_TRUE(reader) << reader.error().text();
  auto before = reader->body(0).slab(0);
  for (std::size_t k = 1; k < slabs.size(); ++k) {
    auto slab = reader->body(0).slab(k);
    ASSERT_TRUE(before && slab);
    EXPECT_EQ((*before)->connectivity == (*slab)->connectivity,
              slabs[k - 1].connectivity == slabs[k].connectivity);
    before = std::move(slab);
  }
}

TEST(T4dReader, StopsWhenTold) {
  const auto path = writeT4d("stopped.t4d", {RandomSlabs(5).make(40)});
  std::size_t reports = 0;
  const auto stop = [&](double) { return ++reports < 5; };
  for (const T4dOpen how : {T4dOpen::Checked, T4dOpen::FromFront}) {
    reports = 0;
    const auto reader = T4dReader::open(path, how, stop);
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().message, "stopped");
    EXPECT_EQ(reports, 5U);
  }
}

TEST(T4dReader, RefusesPipesAndDevicesAtOnce) {
  const auto pipe = temporaryPath("pipe.t4d");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const auto& path : {pipe, std::filesystem::path("/dev/zero")}) {
    const auto reader = T4dReader::open(path);
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().message, "is not a regular file; slabs are read at their offsets");
  }
  std::filesystem::remove(pipe);
}

TEST(T4dReader, ReadsASlabWhenAllThatItDoesNotNeedIsDestroyed) {
  const Sample sample("whole.t4d", {});
  for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
    for (std::size_t k = 0; k < sample.bodies[i].size(); ++k) {
      const std::size_t offset = T4dReader::open(sample.path)->slabOffset(i, k);
      const std::size_t first = sample.endOf("HEAD");
      const std::size_t last = sample.chunks[sample.chunks.size() - 2].offset;
      std::string bytes = sample.bytes;
      std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(first),
                bytes.begin() + static_cast<std::ptrdiff_t>(last), '\xEE');
      for (const ChunkHeader& chunk : sample.partsOf(offset)) {
        bytes.replace(chunk.offset, chunk.end() - chunk.offset, sample.bytes, chunk.offset,
                      chunk.end() - chunk.offset);
      }
      auto reader = T4dReader::open(writeFile("poisoned.t4d", bytes));
      ASSERT_TRUE(reader) << reader.error().text();
      const auto slab = reader->body(i).slab(k);
      ASSERT_TRUE(slab) << slab.error().text();
      EXPECT_TRUE(same(**slab, sample.bodies[i][k]));
      // The slab can still be read after one that cannot.
      for (std::size_t other = 0; other < sample.bodies[i].size(); ++other) {
        EXPECT_EQ(reader->body(i).slab(other).has_value(), other == k);
      }
      const auto again = reader->body(i).slab(k);
      ASSERT_TRUE(again) << again.error().text();
      EXPECT_TRUE(same(**again, sample.bodies[i][k]));
    }
  }
}

TEST(T4dReader, RefusesEveryTruncationAndFromFrontGivesTheWholeSlabsBeforeIt) {
  for (const bool index : {true, false}) {
    const Sample sample("cut.t4d", {0, false, index});
    const auto path = writeFile("being_cut.t4d", sample.bytes);
    std::vector<std::size_t> slabEnds;
    for (const ChunkHeader& chunk : sample.chunks) {
      if (chunk.name() == "SLAB") slabEnds.push_back(chunk.end());
    }
    for (std::size_t length = sample.bytes.size(); length-- > 0;) {
      std::filesystem::resize_file(path, length);
      EXPECT_FALSE(T4dReader::open(path)) << length;
      EXPECT_FALSE(checkT4dFile(path)) << length;
      auto reader = T4dReader::open(path, T4dOpen::FromFront);
      if (length < sample.endOf("HEAD")) {
        EXPECT_FALSE(reader) << length;
        continue;
      }
      ASSERT_TRUE(reader) << length << ": " << reader.error().text();
      EXPECT_TRUE(reader->damage()) << length;
      std::size_t whole = 0;
      for (const std::size_t end : slabEnds) whole += end <= length ? 1 : 0;
      std::size_t found = 0;
      for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
        found += reader->body(i).slabCount();
        EXPECT_EQ(reader->summary(i).slabs, reader->body(i).slabCount());
        for (std::size_t k = 0; k < reader->body(i).slabCount(); ++k) {
          const auto slab = reader->body(i).slab(k);
          ASSERT_TRUE(slab) << slab.error().text();
          EXPECT_TRUE(same(**slab, sample.bodies[i][k]));
        }
      }
      EXPECT_EQ(found, whole) << length;
    }
  }
}

TEST(T4dReader, RefusesEveryByteThatIsNotAsItWasWritten) {
  for (const bool index : {true, false}) {
    const auto path = writeT4d("flipped.t4d", {RandomSlabs(8).make(2)}, {3, false, index});
    const std::string bytes = platform::contents(path);
    const int file = ::open(path.c_str(), O_WRONLY);
    ASSERT_GE(file, 0);
    const auto put = [&](std::size_t at, int byte) {
      const char value = static_cast<char>(byte);
      ASSERT_EQ(::pwrite(file, &value, 1, static_cast<off_t>(at)), 1);
    };
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      for (const int mask : {1, 2, 4, 8, 16, 32, 64, 128, 255}) {
        put(at, bytes[at] ^ mask);
        EXPECT_FALSE(checkT4dFile(path)) << "byte " << at << ", mask " << mask;
      }
      put(at, bytes[at]);
    }
    ::close(file);
    EXPECT_TRUE(checkT4dFile(path));
    std::ofstream(path, std::ios::app) << '\0';
    EXPECT_FALSE(checkT4dFile(path));
    EXPECT_FALSE(T4dReader::open(path));
  }
}

TEST(T4dReader, RefusesBlocksOfCellsThatAreNotAsTheyWereWritten) {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 8;
  connectivity->lowerCount = connectivity->upperCount = 3;
  connectivity->cells.assign(t4d_layout::kBlockRows + 1, {0, 2, 3, 5});
  Slab slab{0, 1, {}, connectivity, {}};
  for (std::uint32_t i = 0; i < 8; ++i) {
    slab.vertices.emplace_back(i, i % 3, i % 2, i < 3 ? 0 : i < 5 ? 0.5 : 1);
  }
  const auto path = writeT4d("blocks.t4d", {{slab}}, {0});
  const auto faultOfBlocks = [&]() -> std::string {
    const auto reader = T4dReader::open(path);
    if (!reader) return reader.error().text();
    const auto blocks = reader->body(0).blocks(0);
    if (!blocks) return blocks.error().text();
    if (*blocks == nullptr) return "has no blocks";
    for (std::size_t i = 0; i < (*blocks)->blockCount(); ++i) {
      const auto block = (*blocks)->read(i);
      if (!block) return block.error().text();
    }
    return {};
  };
  EXPECT_EQ(faultOfBlocks(), "");
  const std::string bytes = platform::contents(path);
  std::map<std::string, int> flipped;
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    if (chunk.name() != "CONN" && chunk.name() != "LAYR" && chunk.name() != "SLAB") continue;
    const std::uint64_t begin = chunk.payload() + chunk.frontBytes;
    const std::uint64_t end = chunk.payload() + chunk.payloadBytes;
    for (std::uint64_t at = begin; at < end; at += 1 + (end - begin) / 7) {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(bytes[at] ^ 1)).flush();
      EXPECT_THAT(faultOfBlocks(), HasSubstr("checksum of block")) << chunk.name() << " " << at;
      file.seekp(static_cast<std::streamoff>(at)).put(bytes[at]);
      ++flipped[chunk.name()];
    }
  }
  EXPECT_EQ(flipped.size(), 3U);
  EXPECT_EQ(faultOfBlocks(), "");
}

TEST(T4dReader, RefusesOtherFilesAndOtherVersions) {
  const std::string good = [] {
    FileBuilder file;
    file.putSimplex(file.putSimplexConnectivity());
    file.putDone();
    return file.bytes();
  }();
  EXPECT_EQ(faultOf(writeFile("good.t4d", good)), "");
  EXPECT_TRUE(checkT4dFile(writeFile("good.t4d", good)));

  const auto faultOfBytes = [](const std::string& bytes) {
    return faultOf(writeFile("other.t4d", bytes));
  };
  EXPECT_THAT(faultOfBytes(""), HasSubstr("has 0 bytes"));
  EXPECT_THAT(faultOfBytes("solid thing, but no 4D mesh"), HasSubstr("not a .t4d file"));
  // Line ends changed, the eighth bit lost.
  std::string text = good;
  text.replace(4, 2, "\n");
  EXPECT_THAT(faultOfBytes(text), HasSubstr("text mode"));
  text = good;
  text.replace(7, 1, "\r\n");
  EXPECT_THAT(faultOfBytes(text), HasSubstr("text mode"));
  text = good;
  text[0] &= 0x7F;
  EXPECT_THAT(faultOfBytes(text), HasSubstr("text mode"));

  for (const auto& [major, minor] : {std::pair<int, int>{0, 9}, {2, 0}, {65535, 1}}) {
    FileBuilder file("{}", static_cast<std::uint16_t>(major), static_cast<std::uint16_t>(minor));
    const auto opened = T4dReader::open(writeFile("version.t4d", file.bytes()));
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::Unsupported);
    EXPECT_THAT(opened.error().message,
                HasSubstr(std::to_string(major) + "." + std::to_string(minor)));
  }
  EXPECT_THAT(faultOf(FileBuilder("{}", 1, 0, 2)), HasSubstr("unknown flags 0x2"));
  EXPECT_THAT(faultOf(FileBuilder("{}")), HasSubstr("'features'"));
  EXPECT_THAT(faultOf(FileBuilder(R"({"features":["wavelets"],"bodies":[{"name":"b"}]})")),
              HasSubstr("'wavelets'"));
  // A later minor version adds only what can be skipped.
  FileBuilder later(R"({"features":[],"bodies":[{"name":"b"}]})", 1, 7);
  later.putSimplex(later.putSimplexConnectivity());
  later.putDone();
  EXPECT_TRUE(checkT4dFile(writeFile("later.t4d", later.bytes())));
  EXPECT_FALSE(T4dReader::open(temporaryPath("missing.t4d")));
  EXPECT_FALSE(T4dReader::open(temporaryPath(".")));
}

TEST(T4dReader, SkipsUnknownOptionalChunksAndRefusesCriticalOnesByName) {
  PayloadWriter note;
  note.putBytes("a note", 6);
  FileBuilder file;
  file.put({'n', 'o', 't', 'e'}, note, 0);
  const SlabParts parts = file.putSimplexConnectivity();
  file.put({'n', 'o', 't', 'e'}, note, 0);
  file.putSimplex(parts);
  file.putDone();
  EXPECT_EQ(faultOf(file), "");
  EXPECT_TRUE(checkT4dFile(writeFile("optional.t4d", file.bytes())));

  FileBuilder critical;
  critical.put({'M', 'U', 'S', 'T'}, note);
  EXPECT_THAT(faultOf(critical), HasSubstr("MUST: a chunk of this type must be understood"));
  const auto opened = T4dReader::open(writeFile("critical.t4d", critical.bytes()));
  EXPECT_EQ(opened.error().code, ErrorCode::Unsupported);

  FileBuilder flags;
  flags.put({'n', 'o', 't', 'e'}, note, 2);
  EXPECT_THAT(faultOf(flags), HasSubstr("unknown flags 0x2"));
  FileBuilder control;
  control.put({'\x1B', '[', 'A', '\xFF'}, note, 0);
  EXPECT_THAT(faultOf(control), HasSubstr("not four letters"));
  for (const t4d_layout::ChunkType& type : {t4d_layout::kHead, t4d_layout::kIndex}) {
    FileBuilder misplaced;
    misplaced.put(type, note);
    EXPECT_THAT(faultOf(misplaced), HasSubstr("cannot be here"));
    FileBuilder optional;
    optional.put(type, note, 0);
    EXPECT_THAT(faultOf(optional), HasSubstr("lacks its critical flag"));
  }
}

TEST(T4dReader, RefusesSlabsWhosePartsAreNotThere) {
  const auto faultWith = [](const std::function<void(FileBuilder&, SlabParts&)>& change) {
    FileBuilder file;
    SlabParts parts = file.putSimplexConnectivity();
    change(file, parts);
    file.putSimplex(parts);
    file.putDone();
    return faultOf(file);
  };
  const std::string notBefore = "does not come before it";
  EXPECT_EQ(faultWith([](FileBuilder&, SlabParts&) {}), "");
  EXPECT_THAT(faultWith([](FileBuilder&, SlabParts& p) { p.connectivity = 0; }),
              HasSubstr(notBefore));
  EXPECT_THAT(faultWith([](FileBuilder&, SlabParts& p) { p.connectivity += 8; }),
              HasSubstr(notBefore));
  // The beginning of the file, and what comes after the slab.
  EXPECT_THAT(faultWith([](FileBuilder& f, SlabParts& p) { p.lower = f.bytes().size() + 8; }),
              HasSubstr(notBefore));
  EXPECT_THAT(faultWith([](FileBuilder& f, SlabParts& p) { p.upper = f.bytes().size() + 400; }),
              HasSubstr(notBefore));
  EXPECT_THAT(faultWith([](FileBuilder&, SlabParts& p) { p.upper = ~std::uint64_t{0}; }),
              HasSubstr(notBefore));
  // A connectivity as a layer, a layer as a connectivity.
  EXPECT_THAT(faultWith([](FileBuilder&, SlabParts& p) { p.lower = p.connectivity; }),
              HasSubstr(notBefore));
  EXPECT_THAT(faultWith([](FileBuilder& f, SlabParts& p) {
                p.connectivity = f.put(t4d_layout::kLayer,
                                       encodeLayer(0, simplexSlab().vertices, {}, {0, false}));
              }),
              HasSubstr(notBefore));
  // A layer that the connectivity does not have.
  EXPECT_THAT(
      faultWith([](FileBuilder& f, SlabParts& p) {
        p.lower = f.put(t4d_layout::kLayer, encodeLayer(0, simplexSlab().vertices, {}, {0, false}));
      }),
      HasSubstr("its connectivity has 0 lower"));
  EXPECT_THAT(faultWith([](FileBuilder&, SlabParts& p) { p.body = 1; }),
              HasSubstr("belongs to body 1, of 1"));
}

TEST(T4dReader, RefusesSlabsThatAreNotSound) {
  const auto faultOfSlab = [](const Slab& slab, const model::TimeSpan& time = {0, 1}) {
    FileBuilder file;
    const SlabParts parts = file.putSimplexConnectivity();
    Slab timed = slab;
    timed.timeBegin = time.begin;
    timed.timeEnd = time.end;
    file.put(t4d_layout::kSlab, encodeSlab(timed, file.fromHere(parts), {0, false}));
    file.putDone(1, time);
    return faultOf(file);
  };
  EXPECT_EQ(faultOfSlab(simplexSlab()), "");
  Slab slab = simplexSlab();
  slab.vertices[2][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(faultOfSlab(slab), HasSubstr("nan"));
  slab.vertices[2][1] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(faultOfSlab(slab), HasSubstr("inf"));
  slab = simplexSlab();
  slab.vertices[2][3] = 2;
  EXPECT_THAT(faultOfSlab(slab), HasSubstr("outside"));
  slab = simplexSlab();
  slab.vertices.pop_back();
  auto ofFour = std::make_shared<model::Connectivity>();
  ofFour->vertexCount = 4;
  slab.connectivity = ofFour;
  EXPECT_THAT(faultOfSlab(slab), HasSubstr("5 interior"));
  slab = simplexSlab();
  slab.attributes = {model::makeAttribute<int>("a", model::Domain::Cell, {1, 2, 3, 4})};
  EXPECT_THAT(faultOfSlab(slab), HasSubstr("'a'"));
  slab.attributes = {model::makeAttribute<int>("a", model::Domain::Cell, {1, 2, 3, 4, 5})};
  EXPECT_EQ(faultOfSlab(slab), "");
  slab.attributes.push_back(slab.attributes[0]);
  EXPECT_THAT(faultOfSlab(slab), HasSubstr("two attributes 'a'"));
  EXPECT_THAT(faultOfSlab(simplexSlab(), {1, 0}), HasSubstr("from time 1 to 0"));
}

TEST(T4dReader, RefusesSlabsThatDoNotFollowOneAnother) {
  FileBuilder overlap;
  const SlabParts parts = overlap.putSimplexConnectivity();
  overlap.putSimplex(parts);
  const std::uint64_t second = overlap.putSimplex(parts, {0.5, 1.5});
  EXPECT_THAT(faultOf(overlap), HasSubstr("begins at time 0.5"));
  // Slabs before the fault can be used when reading from the front.
  auto reader = T4dReader::open(writeFile("overlap.t4d", overlap.bytes()), T4dOpen::FromFront);
  ASSERT_TRUE(reader) << reader.error().text();
  ASSERT_TRUE(reader->damage());
  EXPECT_THAT(reader->damage()->where.text(), HasSubstr("byte " + std::to_string(second)));
  ASSERT_EQ(reader->body(0).slabCount(), 1u);
  EXPECT_TRUE(same(**reader->body(0).slab(0), simplexSlab()));

  FileBuilder apart;
  SlabParts other = apart.putSimplexConnectivity();
  apart.putSimplex(other);
  other.lower =
      apart.put(t4d_layout::kLayer, encodeLayer(1, simplexSlab().vertices, {}, {0, false}));
  apart.putSimplex(other, {1, 2});
  EXPECT_THAT(faultOf(apart), HasSubstr("not the upper layer"));
}

/// A simplex, with an end mark that `change` has made of a right one.
FileBuilder withEndMark(const std::function<void(Done&)>& change) {
  FileBuilder file;
  file.putSimplex(file.putSimplexConnectivity());
  Done done;
  done.chunks = file.chunks();
  done.bodies.resize(1);
  done.bodies[0].slabs = 1;
  done.bodies[0].time = {0, 1};
  change(done);
  file.put(t4d_layout::kDone, encodeDone(done));
  return file;
}

TEST(T4dReader, RefusesEndMarksThatLie) {
  const auto faultWith = [](const std::function<void(Done&)>& change) {
    const FileBuilder file = withEndMark(change);
    auto reader = T4dReader::open(writeFile("done.t4d", file.bytes()), T4dOpen::FromFront);
    EXPECT_TRUE(reader && reader->body(0).slabCount() == 1);
    return faultOf(file);
  };
  EXPECT_EQ(faultWith([](Done&) {}), "");
  EXPECT_THAT(faultWith([](Done& d) { ++d.chunks; }), HasSubstr("chunks come before it"));
  EXPECT_THAT(faultWith([](Done& d) { ++d.bodies[0].slabs; }), HasSubstr("it says 2"));
  EXPECT_THAT(faultWith([](Done& d) { d.bodies[0].time.end = 2; }), HasSubstr("from 0 to 2"));
  EXPECT_THAT(faultWith([](Done& d) { d.bodies.push_back(d.bodies[0]); }), HasSubstr("2 bodies"));
}

/// The offset of a block of a chunk in the file.
std::size_t blockOf(const ChunkHeader& chunk, const std::string& bytes, std::size_t block) {
  std::size_t at = chunk.payload() + chunk.frontBytes;
  for (std::size_t i = 0; i < block; ++i) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + chunk.payload() + 8 * i, sizeof size);
    at += t4d_layout::padded(size);
  }
  return at;
}

TEST(T4dReader, RefusesIndexesAndFootersThatLie) {
  const Sample sample("index.t4d", {0, false, true});
  const ChunkHeader& index = sample.chunks.back();
  const std::size_t footer = sample.bytes.size() - t4d_layout::kFooterBytes;
  const auto faultWith = [&](std::size_t at, std::uint64_t value) {
    std::string bytes = sample.bytes;
    overwrite(bytes, at, value);
    repairChecksums(bytes);
    const auto path = writeFile("lying_index.t4d", bytes);
    EXPECT_FALSE(checkT4dFile(path));
    // Reading from the front does not suffer.
    auto reader = T4dReader::open(path, T4dOpen::FromFront);
    EXPECT_TRUE(reader && reader->body(0).slabCount() == 3);
    EXPECT_TRUE(reader && reader->body(0).slab(2));
    return faultOf(path);
  };
  for (std::size_t at = index.fields(); at + 8 <= index.payload() + index.payloadBytes; at += 8) {
    for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{24}, std::uint64_t{1} << 40,
                                      ~std::uint64_t{0}, std::uint64_t{sample.bytes.size()}}) {
      std::uint64_t truth = 0;
      std::memcpy(&truth, sample.bytes.data() + at, sizeof truth);
      if (truth == value) continue;
      EXPECT_NE(faultWith(at, value), "") << at - index.payload() << " " << value;
    }
  }
  for (std::size_t field = 0; field < 3; ++field) {
    for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{24}, ~std::uint64_t{0},
                                      std::uint64_t{footer}, std::uint64_t{index.offset - 8}}) {
      EXPECT_NE(faultWith(footer + 8 * field, value), "") << field << " " << value;
    }
  }
}

/// A file on a server may change between two requests: all checksums are right.
TEST(T4dReader, RefusesAChunkOfAnotherVersionOfTheFile) {
  Slab other = simplexSlab();
  other.vertices[1][0] = 0.5;
  const std::string before =
      platform::contents(writeT4d("before.t4d", {{simplexSlab()}}, {0, false, true}));
  const std::string after = platform::contents(writeT4d("after.t4d", {{other}}, {0, false, true}));
  ASSERT_EQ(before.size(), after.size());
  for (const ChunkHeader& chunk : listChunks(before)) {
    if (chunk.name() != "SLAB") continue;
    std::string mixed = before;
    mixed.replace(chunk.offset, chunk.bytes(), after.substr(chunk.offset, chunk.bytes()));
    EXPECT_THAT(faultOf(writeFile("mixed.t4d", mixed)), HasSubstr("not what the index says"));
  }
  EXPECT_NE(before.substr(before.size() - t4d_layout::kFooterBytes),
            after.substr(after.size() - t4d_layout::kFooterBytes));
}

TEST(T4dReader, RefusesMoreCellsThanAreAllowed) {
  for (const bool index : {true, false}) {
    const auto path = writeT4d("work.t4d", {{simplexSlab()}, {simplexSlab()}}, {0, false, index});
    for (const T4dOpen how : {T4dOpen::Whole, T4dOpen::Checked}) {
      EXPECT_TRUE(T4dReader::open(path, how));
      EXPECT_TRUE(T4dReader::open(path, how, {}, 10));
      const auto refused = T4dReader::open(path, how, {}, 9);
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().remedy, Remedy::MoreCells);
      EXPECT_THAT(refused.error().message, HasSubstr("has 10 cells"));
    }
  }
  // Sums and products that a u64 does not hold.
  EXPECT_EQ(usualCellLimit(0), 100'000'000u);
  EXPECT_EQ(usualCellLimit(~std::uint64_t{0}), kAnyCells);
  const auto file = withEndMark([](Done& d) { d.bodies[0].tetrahedra = ~std::uint64_t{0} - 1; });
  EXPECT_THAT(faultOf(file), HasSubstr("cells in all its slabs"));
}

/// The offset 0 is "none" for layers only.
TEST(T4dReader, RefusesASlabWithoutConnectivityWhereTheIndexAgrees) {
  std::string bytes =
      platform::contents(writeT4d("no_connectivity.t4d", {{simplexSlab()}}, {0, false, true}));
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    if (chunk.name() == "SLAB") overwrite(bytes, chunk.fields() + 16, std::uint64_t{0});
    if (chunk.name() == "INDX") overwrite(bytes, blockOf(chunk, bytes, 3), std::uint64_t{0});
  }
  repairChecksums(bytes);
  EXPECT_THAT(faultOf(writeFile("no_connectivity.t4d", bytes)),
              HasSubstr("has a connectivity or a layer that is none"));
}

/// -0 equals 0, and so the index may have one where the slab has the other.
TEST(T4dReader, GivesTheTimesOfTheSlabWhereTheIndexHasAnotherZero) {
  std::string bytes = platform::contents(writeT4d("zero.t4d", {{simplexSlab()}}, {0, false, true}));
  for (const ChunkHeader& chunk : listChunks(bytes)) {
    if (chunk.name() == "INDX") overwrite(bytes, blockOf(chunk, bytes, 2), -0.0);
  }
  repairChecksums(bytes);
  auto reader = T4dReader::open(writeFile("zero.t4d", bytes));
  ASSERT_TRUE(reader) << reader.error().text();
  const auto slab = reader->body(0).slab(0);
  ASSERT_TRUE(slab) << slab.error().text();
  EXPECT_FALSE(std::signbit((*slab)->timeBegin));
}

/// A slab without its means is believed only where the index has its bounds; else the slab is read
/// whole, which tells what is wrong.
TEST(T4dReader, GivesNoLayersOfASlabWhoseBoundsInTheIndexLie) {
  const auto path = temporaryPath("bounds.t4d");
  auto writer = T4dWriter::create(path, metadataOf({"cube"}), {.compression = 0});
  ASSERT_TRUE(writer) << writer.error().text();
  model::ScrewRun turn;
  turn.duration = 1;
  turn.screw = {.axisDirection = {0, 0, 1}, .angleDegrees = 90};
  mesh4d::SweepOptions steps;
  steps.steps = mesh4d::StepsPerSegment{3};
  ASSERT_TRUE(mesh4d::sweep(fixtures::cube(1), *model::chainScrews(0, std::span(&turn, 1)), steps,
                            writer->body(0)));
  ASSERT_TRUE(writer->finish());
  const auto sound = T4dReader::open(path);
  ASSERT_TRUE(sound) << sound.error().text();
  const model::Source& body = sound->body(0);
  const std::string bytes = platform::contents(path);
  const ChunkHeader index = listChunks(bytes).back();
  std::size_t at = index.payload();
  ASSERT_EQ(body.slabCount(), 5u);
  for (std::size_t i = 0; i < body.slabCount(); ++i) {
    const auto layered = body.layered(i);
    EXPECT_EQ(layered && *layered, (*body.slab(i))->connectivity->means.size() > 0) << i;
    // Bounds stand in the order of slabs.
    const model::Point3 least = body.bounds(i)->min;
    at = bytes.find(std::string_view(reinterpret_cast<const char*>(&least), sizeof least), at);
    ASSERT_LT(at, index.end());
    std::string lying = bytes;
    overwrite(lying, at, least.x() - 1);
    at += sizeof least;
    repairChecksums(lying);
    const auto reader = T4dReader::open(writeFile("lying_bounds.t4d", lying));
    ASSERT_TRUE(reader) << reader.error().text();
    const auto none = reader->body(0).layered(i);
    EXPECT_TRUE(none && !*none) << i;
    const auto slab = reader->body(0).slab(i);
    ASSERT_FALSE(slab) << i;
    EXPECT_THAT(slab.error().text(), HasSubstr("other cells or bounds than the slab has"));
  }
}

TEST(T4dReader, RefusesLengthsBeyondTheFileWithoutAskingForMemory) {
  const Sample sample("length.t4d", {0, false, true});
  for (const ChunkHeader& chunk : sample.chunks) {
    for (const std::uint64_t length :
         {~std::uint64_t{0}, ~std::uint64_t{0} - 7, std::uint64_t{1} << 63, std::uint64_t{1} << 40,
          std::uint64_t{sample.bytes.size()}}) {
      std::string bytes = sample.bytes;
      overwrite(bytes, chunk.offset + 8, length);
      overwrite(bytes, chunk.offset + 28, platform::crc32c(bytes.data() + chunk.offset, 28));
      const auto path = writeFile("long.t4d", bytes);
      const auto checked = checkT4dFile(path);
      ASSERT_FALSE(checked);
      EXPECT_THAT(checked.error().message, HasSubstr("claims"));
      EXPECT_NE(faultOf(path), "");
    }
  }
}

#ifndef T4D_ADDRESS_SANITIZER
TEST(T4dReaderDeathTest, SaysThatAFileDoesNotFitIntoMemory) {
  // A hole of 100 GiB is a file's honest length, and no bytes on the disk.
  FileBuilder file;
  std::string bytes = file.bytes();
  const std::size_t at = bytes.size();
  file.put({'h', 'u', 'g', 'e'}, {}, 0);
  bytes = file.bytes();
  // A table of 25 blocks of 4 GiB each.
  std::string table;
  for (int i = 0; i < 25; ++i) table += std::string("\xF8\xFF\xFF\xFF\0\0\0\0", 8);
  const std::uint64_t length = table.size() + 25 * std::uint64_t{0xFFFFFFF8};
  overwrite(bytes, at + 8, length);
  overwrite(bytes, at + 16, static_cast<std::uint32_t>(table.size()));
  overwrite(bytes, at + 20, std::uint32_t{25});
  overwrite(bytes, at + 24, platform::crc32c(table.data(), table.size()));
  overwrite(bytes, at + 28, platform::crc32c(bytes.data() + at, 28));
  bytes += table;
  const auto path = writeFile("huge.t4d", bytes);
  std::filesystem::resize_file(path, bytes.size() - table.size() + length);
  const auto open = [&] {
    const rlimit limit = {std::uint64_t{2} << 30, std::uint64_t{2} << 30};
    ::setrlimit(RLIMIT_AS, &limit);
    const auto opened = T4dReader::open(path);
    std::_Exit(!opened && opened.error().message.ends_with("does not fit into memory") ? 0 : 1);
  };
  EXPECT_EXIT(open(), testing::ExitedWithCode(0), "");
  std::filesystem::remove(path);
}
#endif

/// Random damage with checksums that are right again: nothing crashes, and what is given out is
/// sound. T4D_FUZZ_ROUNDS asks for more of it.
TEST(T4dReader, StandsRandomDamageBehindRightChecksums) {
  const char* asked = std::getenv("T4D_FUZZ_ROUNDS");
  const int rounds = asked != nullptr ? std::atoi(asked) : 3000;
  std::mt19937_64 random(7);
  const auto upTo = [&](std::size_t most) { return random() % (most + 1); };
  std::vector<std::string> seeds;
  for (const T4dWriteOptions& options :
       {T4dWriteOptions{0, false, true}, {3, false, true}, {0, true, false}}) {
    seeds.push_back(Sample("seed.t4d", options).bytes);
    seeds.push_back(platform::contents(writeT4d("seed.t4d", {{simplexSlab()}}, options)));
  }
  const std::uint64_t values[] = {0,          1,          7,          24,
                                  0x7F,       0xFF,       0x7FFFFFFF, 0xFFFFFFFF,
                                  1ULL << 32, 1ULL << 61, ~0ULL,      0x7FF0000000000000};
  std::size_t accepted = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string bytes = seeds[upTo(seeds.size() - 1)];
    for (std::size_t edits = 1 + upTo(2); edits > 0; --edits) {
      const std::size_t at = upTo(bytes.size() - 9);
      switch (upTo(5)) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          overwrite(bytes, at, static_cast<std::uint8_t>(values[upTo(11)]));
          break;
        case 2:
          overwrite(bytes, at / 4 * 4, static_cast<std::uint32_t>(values[upTo(11)] + upTo(2)));
          break;
        case 3:
          overwrite(bytes, at / 8 * 8, values[upTo(11)] + upTo(2));
          break;
        case 4:  // Eight bytes from elsewhere: offsets, counts, times.
          bytes.replace(at / 8 * 8, 8, std::string(bytes, upTo(bytes.size() - 8) / 8 * 8, 8));
          break;
        default: {
          // A small step of what is there, as in counts that are off by one.
          bytes[at] = static_cast<char>(bytes[at] + (upTo(1) == 0 ? 1 : -1));
        }
      }
    }
    if (upTo(9) == 0) bytes.resize(upTo(bytes.size()));
    if (bytes.size() > t4d_layout::kFileHeaderBytes + t4d_layout::kChunkHeaderBytes) {
      repairChecksums(bytes);
    }
    const auto path = writeFile("fuzzed.t4d", bytes);
    const bool fine = faultOf(path).empty();
    faultOf(path, T4dOpen::FromFront);
    if (checkT4dFile(path) && fine) ++accepted;
  }
  // Changes of names and numbers are no damage; were none accepted, nothing would be tested.
  EXPECT_GT(accepted, 0u);
}

}  // namespace
}  // namespace t4d::formats
