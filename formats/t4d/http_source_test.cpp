#include "formats/t4d/http_source.h"

#include <array>
#include <chrono>
#include <cstring>

#include <gmock/gmock.h>

#include "formats/t4d/url.h"
#include "formats/test_files.h"
#include "t4d/file.h"
#include "tests/web_server.h"

namespace t4d::formats {
namespace {

/// All tests of this program open URLs.
[[maybe_unused]] const bool kUrlsAreRead = [] {
  readUrls();
  return true;
}();

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint64_t kKiB = 1024;

/// Bytes that differ from their neighbours.
std::string pattern(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 2654435761U >> 13U);
  return bytes;
}

class HttpSourceTest : public testing::Test {
 protected:
  static constexpr std::size_t kSize = 1'000'000;
  const std::string bytes_ = pattern(kSize);
  const std::filesystem::path file_ = writeFile("pattern.t4d", bytes_);
  WebServer server_{file_.parent_path()};

  std::unique_ptr<ByteSource> open(const std::string& path) {
    auto source = openHttpSource(server_.url(path));
    EXPECT_TRUE(source) << source.error().text();
    return source ? std::move(*source) : nullptr;
  }

  /// Reads these bytes, which must be those of the file.
  void read(ByteSource& source, std::uint64_t begin, std::uint64_t end) {
    std::vector<std::byte> got(end - begin);
    const auto done = source.read(begin, got);
    ASSERT_TRUE(done) << done.error().text();
    EXPECT_EQ(std::memcmp(got.data(), bytes_.data() + begin, got.size()), 0);
  }

  std::vector<std::string> ranges(const std::string& path) {
    std::vector<std::string> asked;
    for (const auto& request : server_.requests(path)) asked.push_back(request.range);
    return asked;
  }
};

TEST_F(HttpSourceTest, WhatIsPlannedCloseTogetherIsOneRequest) {
  const auto source = open("plain/pattern.t4d");
  ASSERT_TRUE(source);
  EXPECT_EQ(source->size(), kSize);
  source->plan(std::array{ByteRange{500'000, 500'100}, ByteRange{400'000, 450'000},
                          ByteRange{200'000, 200'010}});
  EXPECT_EQ(source->requests(), 1);  // nothing is fetched before it is read
  read(*source, 500'000, 500'010);
  read(*source, 400'000, 450'000);
  read(*source, 500'010, 500'100);
  EXPECT_EQ(source->requests(), 2);
  read(*source, 200'005, 200'010);
  read(*source, kSize - 256 * kKiB, kSize);
  EXPECT_THAT(ranges("plain/"),
              ElementsAre("bytes=-262144", "bytes=400000-500099", "bytes=200000-200009"));
  EXPECT_EQ(source->bytesRead(), 256 * kKiB + 100'100 + 10);
}

TEST_F(HttpSourceTest, NothingIsFetchedTwice) {
  const auto source = open("plain/pattern.t4d");
  ASSERT_TRUE(source);
  read(*source, 300'000, 300'001);  // 64 KiB at least
  read(*source, 300'000, 300'000 + 64 * kKiB);
  source->plan(std::array{ByteRange{250'000, 800'000}});
  read(*source, 250'000, 800'000);
  EXPECT_THAT(ranges("plain/"), ElementsAre("bytes=-262144", "bytes=300000-365535",
                                            "bytes=250000-299999", "bytes=365536-737855"));
  EXPECT_EQ(source->bytesRead(), kSize - 250'000);
  read(*source, 0, kSize);
  EXPECT_EQ(source->bytesRead(), kSize);
}

TEST_F(HttpSourceTest, ASmallFileIsOneRequest) {
  writeFile("small.t4d", bytes_.substr(0, 1000));
  const auto source = open("plain/small.t4d");
  ASSERT_TRUE(source);
  EXPECT_EQ(source->size(), 1000);
  read(*source, 0, 1000);
  EXPECT_EQ(source->requests(), 1);
}

TEST_F(HttpSourceTest, OnlyAStrongETagIsSentBack) {
  for (const std::string kind : {"plain", "weak-etag", "no-etag"}) {
    SCOPED_TRACE(kind);
    const auto source = open(kind + "/pattern.t4d");
    ASSERT_TRUE(source);
    read(*source, 0, 10);
    const auto requests = server_.requests(kind);
    ASSERT_EQ(requests.size(), 2);
    EXPECT_EQ(requests[0].match, "");
    EXPECT_EQ(requests[1].match.empty(), kind != "plain") << requests[1].match;
  }
}

TEST_F(HttpSourceTest, NamesOfHeadersMayHaveAnyCase) {
  for (const std::string kind : {"lower-case", "upper-case"}) {
    SCOPED_TRACE(kind);
    const auto source = open(kind + "/pattern.t4d");
    ASSERT_TRUE(source);
    read(*source, 0, 10);
    EXPECT_FALSE(server_.requests(kind).at(1).match.empty());
  }
}

TEST_F(HttpSourceTest, AServerThatSaysNothingMoreIsLeft) {
  HttpTimeouts timeouts;
  timeouts.stalledSeconds = 1;
  const auto source = openHttpSource(server_.url("stall/pattern.t4d"), timeouts);
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::Io);
  EXPECT_EQ(source.error().where.text(), server_.url("stall/pattern.t4d"));
  EXPECT_THAT(source.error().message, HasSubstr("too slow"));
  EXPECT_EQ(server_.requests("stall/").size(), 1);
}

TEST_F(HttpSourceTest, TimeAndBytesOfARequestAreLimited) {
  HttpTimeouts timeouts;
  timeouts.connectSeconds = 1;
  timeouts.stalledSeconds = 1;
  const auto fails = [&](const std::string& fault, const char* expected, int seconds) {
    SCOPED_TRACE(fault);
    const auto begin = std::chrono::steady_clock::now();
    const auto source = openHttpSource(server_.url(fault + "/pattern.t4d"), timeouts);
    ASSERT_FALSE(source);
    EXPECT_THAT(source.error().message, HasSubstr(expected));
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(seconds));
  };
  // Ten bytes a second.
  fails("trickle", "too slow", 10);
  fails("trickle-header", "too slow", 10);
  fails("redirect-without-end", "sends a redirect with more than 65536 bytes", 10);
}

TEST_F(HttpSourceTest, ALongHeaderIsRefused) {
  for (const char* fault : {"long-header", "long-header-line"}) {
    const auto source = openHttpSource(server_.url(std::string(fault) + "/pattern.t4d"));
    ASSERT_FALSE(source) << fault;
    EXPECT_EQ(source.error().message, "the server's answer has a header of more than 65536 bytes")
        << fault;
    EXPECT_EQ(server_.requests(fault).size(), 1) << fault;
  }
}

TEST(Url, SchemesAreTold) {
  EXPECT_EQ(schemeOf("HTTPS://host/a.t4d"), "https");
  EXPECT_EQ(schemeOf("s3+x://bucket/a"), "s3+x");
  for (const char* path :
       {"a.t4d", "/a/b.t4d", "http:/a", "./http://a", "://a", "a b://c", "1a://b"}) {
    EXPECT_EQ(schemeOf(path), "") << path;
    EXPECT_EQ(shownName(path), path);
  }
}

TEST(Url, SecretsAreNotShown) {
  EXPECT_EQ(shownName("https://me:pass@host:8/a/b@c.t4d?key=secret#part"),
            "https://host:8/a/b@c.t4d");
  EXPECT_EQ(shownName("http://me@mail:pass@host"), "http://host");
  EXPECT_EQ(shownName("http://host?user@secret"), "http://host");
}

}  // namespace
}  // namespace t4d::formats
