#include "t4d/formats/t4d/array_codec.h"

#include <random>

#include <gmock/gmock.h>
#include <zstd.h>

#include "t4d/formats/t4d/test_slabs.h"

namespace t4d::formats {
namespace {

using model::ScalarType;
using t4d_layout::ByteReader;
using t4d_layout::ByteWriter;
using testing::HasSubstr;

ByteWriter recordOf(std::uint8_t type, std::uint8_t components, std::uint8_t codec,
                    std::uint64_t rows, const std::string& stored, std::uint64_t claimed) {
  ByteWriter record;
  record.put(type);
  record.put(components);
  record.put(codec);
  record.put(std::uint8_t{0});
  record.put(std::uint32_t{0});
  record.put(rows);
  record.put(claimed);
  record.putBytes(stored.data(), stored.size());
  record.pad();
  return record;
}

std::string faultOfRecord(const ByteWriter& record) {
  ByteReader from(record.bytes());
  const auto array = takeArray(from);
  return array ? "" : array.error().message;
}

std::string zstdOf(const std::string& bytes) {
  std::string stored(ZSTD_compressBound(bytes.size()), '\0');
  stored.resize(ZSTD_compress(stored.data(), stored.size(), bytes.data(), bytes.size(), 3));
  return stored;
}

TEST(ArrayCodec, GivesBackWhatWasPutForEveryTypeShapeAndLevel) {
  std::mt19937 random(1);
  for (const ScalarType type : kAllScalarTypes) {
    for (const int components : {1, 3, 4, 255}) {
      for (const std::size_t rows : {0, 1, 63, 64, 65, 1000}) {
        for (const int level : {0, 3, 19}) {
          if (level == 19 && rows != 65) continue;
          std::vector<std::byte> bytes(rows * components * model::scalarSize(type));
          for (std::byte& byte : bytes) byte = std::byte(random() & 7);
          ByteWriter record;
          putArray(record, {type, static_cast<std::uint8_t>(components), bytes}, level);
          EXPECT_EQ(record.size() % 8, 0u);
          ByteReader from(record.bytes());
          const auto array = takeArray(from);
          ASSERT_TRUE(array) << array.error().message;
          EXPECT_EQ(from.left(), 0u);
          EXPECT_EQ(array->type, type);
          EXPECT_EQ(array->components, components);
          EXPECT_EQ(array->rows, rows);
          EXPECT_EQ(array->bytes, bytes);
        }
      }
    }
  }
}

TEST(ArrayCodec, StoresRawWhatCompressionWouldMakeLarger) {
  std::mt19937 random(2);
  std::vector<std::uint8_t> noise(1000);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
  ByteWriter record;
  putArray(record, viewOf(noise), 19);
  EXPECT_EQ(record.size(), t4d_layout::kArrayHeaderBytes + 1000);
  EXPECT_EQ(static_cast<int>(record.data()[2]), 0);
}

TEST(ArrayCodec, TransposesSoThatEachByteOfTheRowsStandsTogether) {
  const std::vector<std::uint16_t> numbers = {0x0102, 0x0304, 0x0506};
  // The record's contents before compression: low bytes, then high bytes.
  const std::string planes = {2, 4, 6, 1, 3, 5};
  const std::string stored = zstdOf(planes);
  ByteReader from({});
  const ByteWriter record = recordOf(3, 1, 1, 3, stored, stored.size());
  from = ByteReader(record.bytes());
  const auto array = takeArrayOf(from, ScalarType::UInt16, 1);
  ASSERT_TRUE(array) << array.error().message;
  std::vector<std::uint16_t> got(3);
  ASSERT_EQ(array->bytes.size(), 6u);
  std::memcpy(got.data(), array->bytes.data(), 6);
  EXPECT_EQ(got, numbers);
}

TEST(ArrayCodec, RefusesEveryTruncation) {
  const std::vector<double> numbers(50, 1.5);
  for (const int level : {0, 3}) {
    ByteWriter record;
    putArray(record, viewOf(numbers), level);
    for (std::size_t length = 0; length < record.size(); ++length) {
      ByteReader from(record.bytes().first(length));
      EXPECT_FALSE(takeArray(from)) << length;
    }
  }
}

TEST(ArrayCodec, RefusesClaimsBeforeItAllocates) {
  const std::uint64_t most = ~std::uint64_t{0};
  const std::string eight(8, '\0');
  // Rows times the size of a row would overflow to exactly the 8 bytes that are stored.
  EXPECT_THAT(faultOfRecord(recordOf(10, 1, 0, (most / 8) + 2, eight, 8)), HasSubstr("claims"));
  EXPECT_THAT(faultOfRecord(recordOf(10, 255, 0, most, eight, 8)), HasSubstr("claims"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, most, eight, 8)), HasSubstr("claims"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, 8 * 32768 + 1, eight, 8)), HasSubstr("claims"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 0, 8, eight, most)), HasSubstr("8 are left"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 0, 7, eight, 8)), HasSubstr("is stored in 8"));
}

TEST(ArrayCodec, RefusesWhatTheHeaderCannotSay) {
  const std::string eight(8, '\0');
  EXPECT_EQ(faultOfRecord(recordOf(1, 8, 0, 1, eight, 8)), "");
  EXPECT_THAT(faultOfRecord(recordOf(0, 8, 0, 1, eight, 8)), HasSubstr("unknown number type 0"));
  EXPECT_THAT(faultOfRecord(recordOf(11, 8, 0, 1, eight, 8)), HasSubstr("unknown number type 11"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 0, 0, 8, eight, 8)), HasSubstr("rows of no numbers"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 8, 2, 1, eight, 8)), HasSubstr("unknown codec 2"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, 0, eight, 8)), HasSubstr("no rows"));
  for (std::size_t at = 3; at < 8; ++at) {
    const ByteWriter good = recordOf(1, 8, 0, 1, eight, 8);
    std::vector<std::byte> bytes(good.bytes().begin(), good.bytes().end());
    bytes[at] = std::byte{1};
    ByteReader from(bytes);
    const auto array = takeArray(from);
    ASSERT_FALSE(array);
    EXPECT_THAT(array.error().message, HasSubstr("reserved"));
  }
}

TEST(ArrayCodec, RefusesFramesThatAreNotExactlyTheArray) {
  const std::string frame = zstdOf(std::string(1000, 'x'));
  const auto fault = [&](std::uint64_t rows, const std::string& stored) {
    return faultOfRecord(recordOf(1, 1, 1, rows, stored, stored.size()));
  };
  EXPECT_EQ(fault(1000, frame), "");
  EXPECT_THAT(fault(999, frame), HasSubstr("does not declare"));
  EXPECT_THAT(fault(1001, frame), HasSubstr("does not declare"));
  EXPECT_THAT(fault(1000, frame + zstdOf("")), HasSubstr("one whole zstd frame"));
  EXPECT_THAT(fault(1000, frame.substr(0, frame.size() - 1)), HasSubstr("one whole zstd frame"));
  EXPECT_THAT(fault(1000, std::string("\x50\x2A\x4D\x18\4\0\0\0abcd", 12)),
              HasSubstr("one whole zstd frame"));
  // A frame of zstd 0.7, from before the standard, which the library may know.
  EXPECT_THAT(fault(4, std::string("\x27\xB5\x2F\xFD\x20\x04\x40\0\4xxxx\xC0\0\0", 16)),
              HasSubstr("one whole zstd frame"));
  // The padding holds one more byte of content than claimed.
  const std::string five(5, 'x');
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 0, 5, five + "p", 5)), HasSubstr("padding"));
}

TEST(Crc32c, HasItsCheckValueAndIsZeroOfNothing) {
  EXPECT_EQ(crc32c("123456789", 9), 0xE3069283u);
  EXPECT_EQ(crc32c("", 0), 0u);
  EXPECT_EQ(crc32c(std::string(32, '\0').data(), 32), 0x8A9136AAu);  // RFC 3720, B.4
}

}  // namespace
}  // namespace t4d::formats
