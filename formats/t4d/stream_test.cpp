#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "formats/t4d/test_slabs.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using testing::HasSubstr;

/// A pipe that a thread writes bytes into, a few at a time.
class Pipe {
 public:
  explicit Pipe(std::string bytes) : path_(temporaryPath("pipe")) {
    std::filesystem::remove(path_);
    EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    writer_ = std::thread([this, bytes = std::move(bytes)] {
      std::ofstream out(path_, std::ios::binary);
      constexpr std::size_t kAtATime = 1000;
      for (std::size_t at = 0; at < bytes.size() && out; at += kAtATime) {
        out << bytes.substr(at, kAtATime) << std::flush;
      }
    });
  }
  ~Pipe() { writer_.join(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::thread writer_;
};

TEST(T4dStreamDeathTest, ReadsFromADescriptorThatHasTheNumberOfAClosedInput) {
  const auto path = writeT4d("stream.t4d", {{RandomSlabs(1).make(3)}});
  EXPECT_EXIT(
      {
        ::close(STDIN_FILENO);
        std::_Exit(T4dStream::open(path) ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(T4dStream, GivesFromAPipeWhatIsInTheFile) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<std::vector<model::Slab>> bodies;
    for (unsigned i = 0; i <= seed % 3; ++i) {
      bodies.push_back(RandomSlabs(3 * seed + i).make(1 + static_cast<int>(seed)));
    }
    const auto path = writeT4d("stream.t4d", bodies, {.index = seed % 2 == 0});
    const auto reader = T4dReader::open(path);
    ASSERT_TRUE(reader) << reader.error().text();
    const Pipe pipe(platform::contents(path));
    EXPECT_TRUE(isPipe(pipe.path()));
    EXPECT_FALSE(isPipe(path));
    auto stream = T4dStream::open(pipe.path());
    ASSERT_TRUE(stream) << stream.error().text();
    std::vector<std::size_t> counts(bodies.size());
    while (true) {
      const auto item = stream->next();
      ASSERT_TRUE(item) << item.error().text();
      if (!*item) break;
      const std::size_t body = (*item)->body;
      EXPECT_TRUE(same(*(*item)->slab, bodies[body].at(counts[body])));
      EXPECT_EQ((*item)->offset, reader->slabOffset(body, counts[body]));
      ++counts[body];
    }
    ASSERT_EQ(stream->bodyCount(), bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      EXPECT_EQ(counts[i], bodies[i].size());
      EXPECT_EQ(stream->summary(i).vertices, reader->summary(i).vertices);
    }
    EXPECT_EQ(stream->fileBytes(), std::filesystem::file_size(path));
    EXPECT_EQ(stream->indexed(), reader->indexed());
    ASSERT_EQ(stream->chunks().size(), reader->chunks().size());
    // It has ended for good.
    const auto after = stream->next();
    EXPECT_TRUE(after && !*after);
  }
}

TEST(T4dStream, RefusesWhatCheckT4dFileRefuses) {
  std::mt19937 random(7);
  for (const bool index : {true, false}) {
    const std::string whole = platform::contents(
        writeT4d("sound.t4d", {RandomSlabs(1).make(4), RandomSlabs(2).make(3)}, {0, false, index}));
    const auto expectRefused = [&](const std::string& bytes, const std::string& what) {
      const auto path = writeFile("damaged.t4d", bytes);
      ASSERT_FALSE(checkT4dFile(path)) << what;
      EXPECT_NE(streamFaultOf(path), "") << what;
    };
    for (std::size_t size = 0; size < whole.size(); size += 1 + random() % 13) {
      expectRefused(whole.substr(0, size), "truncated to " + std::to_string(size));
    }
    for (std::size_t at = 0; at < whole.size(); at += 1 + random() % 13) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      expectRefused(bytes, "flipped at " + std::to_string(at));
    }
    expectRefused(whole + '\0', "one byte more");
    expectRefused(whole + whole, "twice");
  }
}

TEST(T4dStream, SaysWhereAPipeEnds) {
  const std::string whole = platform::contents(writeT4d("short.t4d", {{simplexSlab()}}));
  const ChunkHeader slab = listChunks(whole).at(2);
  EXPECT_EQ(slab.name(), "SLAB");
  const Pipe inside(whole.substr(0, slab.payload() + 8));
  EXPECT_THAT(streamFaultOf(inside.path()),
              HasSubstr("byte " + std::to_string(slab.payload() + 8) + ": the file ends here"));
  const Pipe between(whole.substr(0, slab.end()));
  EXPECT_THAT(streamFaultOf(between.path()), HasSubstr("ends before its end mark"));
}

TEST(T4dStream, CountsCellsAsTheyCome) {
  const auto path = writeT4d("cells.t4d", {{simplexSlab()}});
  auto stream = T4dStream::open(path, 4);
  ASSERT_TRUE(stream) << stream.error().text();
  const auto item = stream->next();
  ASSERT_FALSE(item);
  EXPECT_EQ(item.error().remedy, Remedy::MoreCells);
}

}  // namespace
}  // namespace t4d::formats
