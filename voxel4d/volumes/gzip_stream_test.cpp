#include "voxel4d/volumes/gzip_stream.h"

#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include "platform/test_folder.h"

namespace t4d::voxel4d {
namespace {

std::string packed(const std::string& bytes, int level, bool withHeader = false) {
  z_stream stream{};
  deflateInit2(&stream, level, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  gz_header header{};
  std::string name = "a name";
  std::string extra(300, 'x');
  if (withHeader) {
    header.name = reinterpret_cast<Bytef*>(name.data());
    header.comment = reinterpret_cast<Bytef*>(name.data());
    header.extra = reinterpret_cast<Bytef*>(extra.data());
    header.extra_len = static_cast<uInt>(extra.size());
    header.hcrc = 1;
    deflateSetHeader(&stream, &header);
  }
  std::string result(deflateBound(&stream, bytes.size()) + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

/// What zlib makes of the first member, if it is whole and sound.
std::optional<std::string> byZlib(const std::string& file) {
  z_stream stream{};
  inflateInit2(&stream, 15 + 16);
  std::string result(4'000'000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(file.data()));
  stream.avail_in = static_cast<uInt>(file.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  const int code = inflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  inflateEnd(&stream);
  if (code != Z_STREAM_END) return std::nullopt;
  return result;
}

struct Unpacked {
  std::string bytes;
  GzipStream::State state;
};

/// Unpacks a file in pieces of this size.
Unpacked unpacked(const std::string& file, std::size_t piece = 100'000) {
  const platform::TestFolder folder;
  auto opened = platform::OpenFile::openRegular(folder.write("a.gz", file));
  EXPECT_TRUE(opened);
  GzipStream stream(std::move(*opened));
  Unpacked result;
  std::string space(piece, '\0');
  while (stream.state() == GzipStream::State::Good) {
    const std::size_t got = stream.read(std::as_writable_bytes(std::span(space)));
    result.bytes.append(space, 0, got);
  }
  result.state = stream.state();
  return result;
}

std::string sample(std::mt19937& random, std::size_t size, unsigned values) {
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random() % values);
  return bytes;
}

TEST(GzipStream, UnpacksMembersOfAnyLevelInPiecesOfAnySize) {
  std::mt19937 random(7);
  for (const unsigned values : {1U, 3U, 256U}) {
    for (const int level : {0, 1, 6, 9}) {
      const std::string one = sample(random, 700'001, values);
      const std::string two = sample(random, 3, values);
      const std::string file = packed(one, level, true) + packed("", level) + packed(two, level);
      for (const std::size_t piece : {std::size_t{997}, std::size_t{1} << 20U}) {
        const Unpacked got = unpacked(file, piece);
        EXPECT_EQ(got.state, GzipStream::State::End);
        EXPECT_TRUE(got.bytes == one + two) << values << ' ' << level << ' ' << piece;
      }
      const Unpacked more = unpacked(file + "what is not a member", 4096);
      EXPECT_EQ(more.state, GzipStream::State::End);
      EXPECT_TRUE(more.bytes == one + two);
    }
  }
}

TEST(GzipStream, EachCutIsNoticed) {
  std::mt19937 random(8);
  const std::string bytes = sample(random, 2000, 5);
  const std::string file = packed(bytes, 6, true);
  for (std::size_t size = 0; size < file.size(); ++size) {
    const Unpacked got = unpacked(file.substr(0, size));
    EXPECT_EQ(got.state, GzipStream::State::CutOff) << size << " of " << file.size();
    EXPECT_EQ(got.bytes, bytes.substr(0, got.bytes.size()));
  }
}

TEST(GzipStream, RefusesWhatZlibRefuses) {
  std::mt19937 random(9);
  const std::string file = packed(sample(random, 3000, 5), 6);
  int refused = 0;
  for (int run = 0; run < 3000; ++run) {
    std::string changed = file;
    changed[random() % changed.size()] ^= static_cast<char>(1U << random() % 8);
    const auto expected = byZlib(changed);
    const Unpacked got = unpacked(changed);
    ASSERT_EQ(got.state == GzipStream::State::End, expected.has_value()) << run;
    EXPECT_TRUE(!expected || got.bytes == *expected) << run;
    refused += expected ? 0 : 1;
  }
  EXPECT_GT(refused, 2500);
}

}  // namespace
}  // namespace t4d::voxel4d
