#include "formats/t4d/salvage.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "formats/t4d/test_slabs.h"

/// Whatever is damaged, every slab whose own bytes, connectivity and layers are whole is saved.
namespace t4d::formats {
namespace {

using model::Slab;
using testing::HasSubstr;

/// Bytes of a file from `begin` to `end`, not included.
struct Range {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool meets(std::size_t from, std::size_t to) const { return begin < to && from < end; }
};

/// A file of random slabs, and which bytes each slab needs.
struct Original {
  struct Needs {
    std::uint32_t body = 0;
    std::size_t number = 0;  // in its body
    std::vector<Range> chunks;
  };
  std::vector<std::vector<Slab>> bodies;
  std::string bytes;
  std::vector<ChunkHeader> chunks;
  std::vector<Needs> slabs;  // in file order

  explicit Original(unsigned seed)
      : bodies{RandomSlabs(seed).make(5), RandomSlabs(seed + 1000).make(3)} {
    const auto path = writeT4d("sample.t4d", bodies,
                               {.compression = seed % 2 == 0 ? 3 : 0, .index = seed % 3 != 0});
    bytes = platform::contents(path);
    chunks = listChunks(bytes);
    std::vector<std::size_t> next(bodies.size(), 0);
    for (const ChunkHeader& chunk : chunks) {
      if (chunk.name() != "SLAB") continue;
      Needs needs;
      const auto load = [&](std::size_t at, auto& into) {
        std::memcpy(&into, bytes.data() + chunk.fields() + at, sizeof into);
      };
      load(40, needs.body);
      needs.number = next[needs.body]++;
      needs.chunks.push_back({chunk.offset, chunk.end()});
      for (const std::size_t at : {16, 24, 32}) {
        std::uint64_t distance = 0;
        load(at, distance);
        if (distance == 0) continue;
        for (const ChunkHeader& part : chunks) {
          if (part.offset == chunk.offset - distance)
            needs.chunks.push_back({part.offset, part.end()});
        }
      }
      slabs.push_back(needs);
    }
  }

  const ChunkHeader& chunk(const std::string& type, std::size_t number = 0) const {
    for (const ChunkHeader& chunk : chunks) {
      if (chunk.name() == type && number-- == 0) return chunk;
    }
    ADD_FAILURE() << "no chunk " << type;
    return chunks.front();
  }
};

/// Expects that everything possible is saved of `sample`, with these ranges of its bytes damaged,
/// bit for bit.
void expectSaved(const Original& sample, const std::string& bytes,
                 const std::vector<Range>& damaged) {
  std::string trace = "damaged:";
  for (const Range& range : damaged) {
    trace += " " + std::to_string(range.begin) + "-" + std::to_string(range.end);
  }
  SCOPED_TRACE(trace);
  std::vector<std::vector<const Slab*>> expected(sample.bodies.size());
  for (const Original::Needs& slab : sample.slabs) {
    bool whole = true;
    for (const Range& chunk : slab.chunks) {
      for (const Range& range : damaged) whole = whole && !range.meets(chunk.begin, chunk.end);
    }
    if (whole) expected[slab.body].push_back(&sample.bodies[slab.body][slab.number]);
  }
  // Bodies that enclose nothing are left out of a damaged file.
  std::erase_if(expected, [&](const std::vector<const Slab*>& slabs) {
    return !damaged.empty() && std::none_of(slabs.begin(), slabs.end(), [](const Slab* slab) {
      return slab->timeBegin < slab->timeEnd && !slab->connectivity->cells.empty();
    });
  });

  auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
  ASSERT_TRUE(salvage) << salvage.error().text();
  EXPECT_EQ(salvage->losses().empty(), damaged.empty());
  ASSERT_EQ(salvage->metadata().bodies.size(), expected.size());
  std::uint64_t saved = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const model::Source& body = salvage->body(i);
    ASSERT_EQ(body.slabCount(), expected[i].size());
    for (std::size_t k = 0; k < expected[i].size(); ++k) {
      const auto slab = body.slab(k);
      ASSERT_TRUE(slab) << slab.error().text();
      EXPECT_TRUE(same(**slab, *expected[i][k]));
    }
    saved += body.slabCount();
  }
  EXPECT_EQ(salvage->slabsSaved(), saved);
  EXPECT_EQ(salvage->slabsKnown().value_or(sample.slabs.size()), sample.slabs.size());
}

TEST(T4dSalvage, SavesAllOfAWholeFile) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const Original sample(seed);
    expectSaved(sample, sample.bytes, {});
  }
}

TEST(T4dSalvage, SavesWhatLiesBeforeACut) {
  std::mt19937 random(1);
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Original sample(seed);
    const std::size_t head = sample.chunk("HEAD").end();
    for (int i = 0; i < 10; ++i) {
      const std::size_t length =
          std::uniform_int_distribution<std::size_t>(head, sample.bytes.size() - 1)(random);
      expectSaved(sample, sample.bytes.substr(0, length), {{length, sample.bytes.size()}});
    }
    for (const ChunkHeader& chunk : sample.chunks) {
      // Of a file without index nothing is missing at the end of DONE.
      if (chunk.end() == sample.bytes.size()) continue;
      expectSaved(sample, sample.bytes.substr(0, chunk.end()),
                  {{chunk.end(), sample.bytes.size()}});
    }
  }
}

TEST(T4dSalvage, SavesAllThatAFlippedBitDoesNotTouch) {
  std::mt19937 random(2);
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Original sample(seed);
    auto place = std::uniform_int_distribution<std::size_t>(0, sample.bytes.size() - 1);
    for (int i = 0; i < 10; ++i) {
      std::string bytes = sample.bytes;
      std::vector<Range> damaged;
      for (int flips = 1 + i % 3; flips > 0; --flips) {
        const std::size_t at = place(random);
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
        if (bytes[at] == sample.bytes[at]) continue;
        damaged.push_back({at, at + 1});
      }
      expectSaved(sample, bytes, damaged);
    }
  }
}

TEST(T4dSalvage, SavesAllAroundABlockOfZeros) {
  std::mt19937 random(3);
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Original sample(seed);
    for (int i = 0; i < 6; ++i) {
      std::string bytes = sample.bytes;
      const Range range = {random() % (bytes.size() / 512) * 512, 0};
      const std::size_t end = std::min(range.begin + 512 * (1 + random() % 4), bytes.size());
      std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(range.begin),
                bytes.begin() + static_cast<std::ptrdiff_t>(end), '\0');
      if (bytes == sample.bytes) continue;
      expectSaved(sample, bytes, {{range.begin, end}});
    }
  }
}

/// The losses of a file, a line each.
std::string lossesOf(const std::string& bytes) {
  const auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
  if (!salvage) return salvage.error().text();
  std::string lines;
  for (const T4dLoss& loss : salvage->losses()) {
    lines += std::to_string(loss.offset) + ": " + loss.what + "\n";
  }
  return lines;
}

/// What is saved is slabs of `sample`, in order, bit for bit, and each slab is saved or listed as
/// lost. Returns how many are saved.
std::uint64_t expectAddsUp(const Original& sample, const std::string& bytes) {
  auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
  EXPECT_TRUE(salvage) << salvage.error().text();
  std::uint64_t found = 0;
  for (std::size_t i = 0; i < salvage->metadata().bodies.size(); ++i) {
    const std::size_t number = salvage->metadata().bodies[i].name.back() - '0';
    auto next = sample.bodies[number].begin();
    for (std::size_t k = 0; k < salvage->body(i).slabCount(); ++k) {
      const auto slab = salvage->body(i).slab(k);
      EXPECT_TRUE(slab) << slab.error().text();
      // Without an index a slab of nothing may be there twice.
      const model::Connectivity& connectivity = *(*slab)->connectivity;
      if ((*slab)->timeBegin == (*slab)->timeEnd &&
          connectivity.lowerCount + connectivity.upperCount == 0) {
        next = sample.bodies[number].begin();
      }
      next = std::find_if(next, sample.bodies[number].end(),
                          [&](const Slab& one) { return bool(same(one, **slab)); });
      EXPECT_NE(next, sample.bodies[number].end()) << "slab " << k << " of body " << number;
      if (next == sample.bodies[number].end()) return found;
      ++next;
      ++found;
    }
  }
  const auto count = static_cast<std::uint64_t>(
      std::count_if(salvage->losses().begin(), salvage->losses().end(),
                    [](const T4dLoss& loss) { return loss.time.has_value(); }));
  if (const auto known = salvage->slabsKnown()) {
    EXPECT_GE(*known, sample.slabs.size());  // slabs of another file are lost, too
    EXPECT_LE(found + count, *known);
    // Without the index it is not known when lost slabs were.
    const std::string losses = lossesOf(bytes);
    if (salvage->metadataSaved() && losses.find("INDX") == losses.npos) {
      EXPECT_EQ(found + count, *known) << losses;
    }
  }
  return found;
}

/// Where slabs can be told from one another, and all bodies enclose something.
bool isPlain(const Original& sample) {
  return std::all_of(sample.bodies.begin(), sample.bodies.end(), [](const auto& slabs) {
    return std::any_of(slabs.begin(), slabs.end(), [](const Slab& slab) {
      return slab.timeBegin < slab.timeEnd && !slab.connectivity->cells.empty();
    });
  });
}

TEST(T4dSalvage, SavesAllWhereBytesWereInsertedBetweenChunks) {
  for (unsigned seed = 1; seed < 40; ++seed) {
    const Original sample(seed);
    if (seed % 3 == 0 || !isPlain(sample)) continue;
    for (const ChunkHeader& chunk : sample.chunks) {
      for (const std::size_t inserted : {8, 64, 4096}) {
        SCOPED_TRACE(fmt::format("seed {}: {} bytes at {}", seed, inserted, chunk.offset));
        std::string bytes = sample.bytes;
        bytes.insert(chunk.offset, inserted, '\0');
        EXPECT_EQ(expectAddsUp(sample, bytes), sample.slabs.size());
      }
    }
    const auto salvage =
        T4dSalvage::open(writeFile("damaged.t4d", std::string(8, '\0') + sample.bytes));
    ASSERT_TRUE(salvage) << salvage.error().text();
    EXPECT_TRUE(salvage->metadataSaved());
    EXPECT_EQ(salvage->slabsSaved(), sample.slabs.size());
  }
}

TEST(T4dSalvage, NeverTakesAPartForAnotherWhereBytesWereInsertedOrLost) {
  std::mt19937 random(5);
  for (unsigned seed = 1; seed < 60; ++seed) {
    const Original sample(seed);
    const Original other(seed + 100);
    if (seed % 3 == 0) continue;
    const auto boundary = [&](const Original& of) {
      return of.chunks[random() % of.chunks.size()].offset;
    };
    const auto anywhere = [&] { return random() % sample.bytes.size() / 8 * 8; };
    for (int i = 0; i < 40; ++i) {
      // A range of this file or of another goes in, or a range is lost, mostly of whole chunks.
      const bool whole = i % 4 != 0;
      const bool foreign = i % 3 == 0;
      const Original& from = foreign ? other : sample;
      std::size_t begin = whole ? boundary(from) : anywhere() % from.bytes.size();
      std::size_t end = whole ? boundary(from) : anywhere() % from.bytes.size();
      if (begin > end) std::swap(begin, end);
      const std::size_t at = whole ? boundary(sample) : anywhere();
      SCOPED_TRACE(fmt::format("seed {}, {}: {} to {} at {}", seed, i, begin, end, at));
      std::string bytes = sample.bytes;
      if (i % 2 == 0 || foreign) {
        bytes.insert(at, from.bytes.substr(begin, end - begin));
      } else {
        bytes.erase(begin, end - begin);
      }
      expectAddsUp(sample, bytes);
    }
  }
}

TEST(T4dSalvage, SaysWhatFollowsAWholeFile) {
  for (const unsigned seed : {3U, 4U}) {  // without index and with
    const Original sample(seed);
    const std::string size = std::to_string(sample.bytes.size());
    EXPECT_THAT(lossesOf(sample.bytes + "five!"),
                testing::Eq(size + ": 5 bytes follow the end of the file\n"));
    EXPECT_THAT(lossesOf(sample.bytes + sample.bytes),
                testing::Eq(size + ": " + size + " bytes follow the end of the file\n"));
  }
}

TEST(T4dSalvage, NamesBodiesByNumberWithoutHead) {
  const Original sample(2);
  std::string bytes = sample.bytes;
  bytes[sample.chunk("HEAD").payload() + 5] ^= 1;
  const auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
  ASSERT_TRUE(salvage);
  EXPECT_FALSE(salvage->metadataSaved());
  EXPECT_THAT(salvage->metadata().bodies,
              testing::ElementsAre(testing::Field(&BodyInfo::name, "body 0"),
                                   testing::Field(&BodyInfo::name, "body 1")));
  EXPECT_EQ(salvage->slabsSaved(), sample.slabs.size());
  EXPECT_EQ(salvage->slabsKnown(), sample.slabs.size());
  EXPECT_THAT(lossesOf(bytes), HasSubstr("24: the checksum of the chunk HEAD"));
}

TEST(T4dSalvage, GoesOnAfterADamagedFileHeader) {
  const Original sample(2);
  std::string bytes = sample.bytes;
  std::fill_n(bytes.begin(), 24, '\0');
  const auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
  ASSERT_TRUE(salvage);
  EXPECT_EQ(salvage->slabsSaved(), sample.slabs.size());
  ASSERT_EQ(salvage->losses().size(), 1U);
  EXPECT_EQ(salvage->losses()[0].offset, 0U);
}

TEST(T4dSalvage, SaysWhenALostSlabWas) {
  const Original sample(4);  // with index
  const ChunkHeader& lost = sample.chunk("SLAB", 2);
  const Original::Needs& needs = sample.slabs[2];
  const Slab& slab = sample.bodies[needs.body][needs.number];
  for (const std::size_t at : {lost.offset, lost.payload() + 60}) {
    std::string bytes = sample.bytes;
    bytes[at] ^= 4;
    const auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
    ASSERT_TRUE(salvage);
    ASSERT_EQ(salvage->losses().size(), 1U) << lossesOf(bytes);
    const T4dLoss& loss = salvage->losses()[0];
    EXPECT_EQ(loss.offset, lost.offset);
    ASSERT_TRUE(loss.time);
    EXPECT_EQ(loss.time->begin, slab.timeBegin);
    EXPECT_EQ(loss.time->end, slab.timeEnd);
  }
}

TEST(T4dSalvage, NamesWhatIsMissingAtTheEnd) {
  const Original sample(4);
  const auto cutAt = [&](std::size_t length) { return lossesOf(sample.bytes.substr(0, length)); };
  const auto is = [&](std::size_t offset, const std::string& what) {
    return testing::StartsWith(std::to_string(offset) + ": " + what);
  };
  const std::size_t done = sample.chunk("DONE").offset;
  const std::size_t index = sample.chunk("INDX").offset;
  const std::size_t footer = sample.bytes.size() - 40;
  EXPECT_THAT(cutAt(done), is(done, "the file ends without end mark (DONE), index (INDX), footer"));
  EXPECT_THAT(cutAt(index), is(index, "the file ends without index (INDX), footer"));
  EXPECT_THAT(cutAt(footer), HasSubstr("footer"));
  EXPECT_THAT(cutAt(footer + 11),
              testing::Eq(std::to_string(footer) +
                          ": the file is truncated: 11 of the 40 bytes of its footer are left\n"));
  std::string bytes = sample.bytes;
  bytes[footer + 17] ^= 1;
  EXPECT_THAT(lossesOf(bytes), is(footer, "the footer's checksum does not match"));
  const ChunkHeader& slab = sample.chunk("SLAB", 3);
  EXPECT_THAT(cutAt(slab.payload() + 9),
              is(slab.offset, "the chunk SLAB claims " + std::to_string(slab.payloadBytes) +
                                  " bytes where 9 are left"));
}

TEST(T4dSalvage, RefusesWhatIsNotDamagedButForOthers) {
  EXPECT_THAT(lossesOf("solid cube\nfacet normal 0 0 1\n"), HasSubstr("signature"));
  EXPECT_THAT(lossesOf(""), HasSubstr("the file has 0 bytes"));
  EXPECT_THAT(lossesOf(FileBuilder(R"({"features":[],"bodies":[{"name":"b"}]})", 7).bytes()),
              HasSubstr("version 7.1"));
  EXPECT_THAT(lossesOf(FileBuilder(R"({"features":["folded"],"bodies":[{"name":"b"}]})").bytes()),
              HasSubstr("folded"));
  EXPECT_FALSE(T4dSalvage::open("/nowhere/at.all"));
}

TEST(T4dSalvage, FindsWhetherASlabCanBeSavedFromTheBeginningAlone) {
  const auto finds = [](const std::string& bytes, std::uint64_t first) {
    return T4dSalvage::finds(writeFile("damaged.t4d", bytes), first);
  };
  for (const std::uint16_t version : {1, 2}) {
    FileBuilder file(R"({"features":[],"bodies":[{"name":"b"}]})", version);
    file.putSimplex(file.putSimplexConnectivity());
    const std::size_t size = file.bytes().size();
    EXPECT_EQ(finds(file.bytes(), size), version == 1);
    EXPECT_EQ(finds(file.bytes() + "more", size + 100), version == 1);
    EXPECT_FALSE(finds(file.bytes(), size - 1));
  }
  EXPECT_FALSE(T4dSalvage::finds("/nowhere/at.all", 1));
}

TEST(T4dSalvage, LeavesOutABodyThatEnclosesNothing) {
  FileBuilder file(R"({"features":[],"bodies":[{"name":"cap"},{"name":"solid"}]})");
  SlabParts parts = file.putSimplexConnectivity();
  parts.body = 1;
  file.putSimplex(parts);
  const auto salvage = T4dSalvage::open(writeFile("damaged.t4d", file.bytes()));
  ASSERT_TRUE(salvage);
  EXPECT_THAT(salvage->metadata().bodies,
              testing::ElementsAre(testing::Field(&BodyInfo::name, "solid")));
  EXPECT_THAT(lossesOf(file.bytes()), HasSubstr("the body 'cap': none of its slabs is whole"));
}

TEST(T4dSalvage, SurvivesFilesThatLie) {
  std::mt19937 random(4);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Original sample(seed);
    for (int i = 0; i < 40; ++i) {
      std::string bytes = sample.bytes;
      for (int changes = 1 + i % 4; changes > 0; --changes) {
        const ChunkHeader& chunk = sample.chunks[random() % sample.chunks.size()];
        // Mostly where counts and offsets are.
        const std::size_t at =
            chunk.payload() +
            random() % std::min<std::size_t>(std::max<std::size_t>(chunk.payloadBytes, 1), 80);
        bytes[at] = static_cast<char>(random());
      }
      repairChecksums(bytes);
      auto salvage = T4dSalvage::open(writeFile("damaged.t4d", bytes));
      if (!salvage) continue;
      for (std::size_t b = 0; b < salvage->metadata().bodies.size(); ++b) {
        for (std::size_t k = 0; k < salvage->body(b).slabCount(); ++k) {
          const auto slab = salvage->body(b).slab(k);
          ASSERT_TRUE(slab) << slab.error().text();
          EXPECT_TRUE(model::checkSlab(**slab));
        }
      }
    }
  }
}

}  // namespace
}  // namespace t4d::formats
