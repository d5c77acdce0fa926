#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "platform/crc32c.h"
#include "platform/sha256.h"

namespace t4d::platform {
namespace {

TEST(Crc32c, HasItsCheckValues) {
  for (const auto crc : {crc32c, crc32cByTable}) {
    EXPECT_EQ(crc("123456789", 9, 0), 0xE3069283U);
    EXPECT_EQ(crc("", 0, 0), 0U);
    EXPECT_EQ(crc(std::string(32, '\0').data(), 32, 0), 0x8A9136AAU);  // RFC 3720, B.4
  }
}

/// Tries any size, at any address, and in two pieces.
TEST(Crc32c, InstructionAndTableAgree) {
  std::vector<unsigned char> bytes(20'000);
  std::iota(bytes.begin(), bytes.end(), static_cast<unsigned char>(1));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] ^= static_cast<unsigned char>(i / 251);
  for (std::size_t size = 0; size + 7 < bytes.size(); size += size < 100 ? 1 : 997) {
    for (std::size_t from = 0; from < 8; from += 3) {
      const std::uint32_t crc = crc32c(bytes.data() + from, size);
      EXPECT_EQ(crc, crc32cByTable(bytes.data() + from, size)) << size;
      const std::size_t half = size / 3;
      EXPECT_EQ(crc,
                crc32c(bytes.data() + from + half, size - half, crc32c(bytes.data() + from, half)));
    }
  }
}

std::string sha256(const std::string& text, std::size_t piece) {
  Sha256 digest;
  for (std::size_t at = 0; at < text.size(); at += piece) {
    digest.add(std::as_bytes(std::span(text)).subspan(at, std::min(piece, text.size() - at)));
  }
  return digest.finish();
}

/// FIPS 180-4, and NIST's long message.
TEST(Sha256, HasThePublishedValues) {
  const std::pair<std::string, std::string> known[] = {
      {"", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
      {"abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
      {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
       "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
      {std::string(1'000'000, 'a'),
       "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"}};
  for (const auto& [text, digest] : known) {
    for (const std::size_t piece : {1U, 63U, 64U, 1000U}) EXPECT_EQ(sha256(text, piece), digest);
  }
}

}  // namespace
}  // namespace t4d::platform
