#include "formats/t4d/array_codec.h"

#include <random>

#include <gmock/gmock.h>
#include <zstd.h>

#include "formats/t4d/test_slabs.h"

namespace t4d::formats {
namespace {

using model::ScalarType;
using t4d_layout::PayloadReader;
using t4d_layout::PayloadView;
using t4d_layout::PayloadWriter;
using testing::HasSubstr;

PayloadWriter recordOf(std::uint8_t type, std::uint8_t components, std::uint8_t codec,
                       std::uint64_t rows, const std::vector<std::string>& blocks) {
  PayloadWriter record;
  record.put(type);
  record.put(components);
  record.put(codec);
  record.put(std::uint8_t{0});
  record.put(std::uint32_t{0});
  record.put(rows);
  for (const std::string& block : blocks) {
    const auto bytes = std::as_bytes(std::span(block));
    record.putBlock(StoredBlock({bytes.begin(), bytes.end()}));
  }
  return record;
}

Result<Array> arrayIn(const PayloadWriter& record) {
  const PayloadView view = record.view();
  PayloadReader from(view);
  auto array = takeArray(from);
  if (array) {
    EXPECT_EQ(from.left(), 0u);
    EXPECT_EQ(from.blocksLeft(), 0u);
  }
  return array;
}

std::string faultOfRecord(const PayloadWriter& record) {
  const auto array = arrayIn(record);
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
          PayloadWriter record;
          putArray(record, {type, static_cast<std::uint8_t>(components), bytes}, level);
          const auto array = arrayIn(record);
          ASSERT_TRUE(array) << array.error().message;
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
  PayloadWriter record;
  putArray(record, viewOf(noise), 19);
  EXPECT_EQ(record.size(), t4d_layout::kArrayHeaderBytes);
  ASSERT_EQ(record.blocks().size(), 1u);
  EXPECT_EQ(record.blocks()[0].size(), 1000u);
  EXPECT_EQ(static_cast<int>(record.data()[2]), 0);
}

TEST(ArrayCodec, TransposesSoThatEachByteOfTheRowsStandsTogether) {
  const std::vector<std::uint16_t> numbers = {0x0102, 0x0304, 0x0506};
  // The record's contents before compression: low bytes, then high bytes.
  const std::string planes = {2, 4, 6, 1, 3, 5};
  const std::string stored = zstdOf(planes);
  const auto array = arrayIn(recordOf(3, 1, 1, 3, {stored}));
  ASSERT_TRUE(array) << array.error().message;
  std::vector<std::uint16_t> got(3);
  ASSERT_EQ(array->bytes.size(), 6u);
  std::memcpy(got.data(), array->bytes.data(), 6);
  EXPECT_EQ(got, numbers);
}

TEST(ArrayCodec, StoresRepeatedNumbersAsReferences) {
  // The example of SPEC.md.
  const std::vector<std::uint32_t> numbers = {7, 8, 9, 10, 8, 7, 9, 11};
  const std::string content = {0,  3, 0, 5, 0, 4, 0, 0,  // columns of distances
                               14, 2, 2, 2, 2,           // first bytes of the differences
                               0,  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const auto array = arrayIn(recordOf(5, 4, 2, 2, {zstdOf(content)}));
  ASSERT_TRUE(array) << array.error().message;
  std::vector<std::uint32_t> got(8);
  std::memcpy(got.data(), array->bytes.data(), 32);
  EXPECT_EQ(got, numbers);
  const auto fault = [](const std::string& wrong) {
    return faultOfRecord(recordOf(5, 4, 2, 2, {zstdOf(wrong)}));
  };
  std::string other = content;
  other[0] = 1;
  EXPECT_THAT(fault(other), HasSubstr("before the first"));
  other = content;
  other[4] = 6;
  EXPECT_THAT(fault(other), HasSubstr("before the first"));
  other = content;
  other[6] = 1;
  EXPECT_THAT(fault(other), HasSubstr("has 5 numbers that repeat no other, and needs 4"));
  other = content;
  other[1] = 0;
  EXPECT_THAT(fault(other), HasSubstr("lacks numbers"));
  EXPECT_THAT(fault(content.substr(0, 7)), HasSubstr("does not declare"));
  EXPECT_THAT(fault(content.substr(0, 27)), HasSubstr("not whole"));
  EXPECT_THAT(fault(content + std::string(16, 0)), HasSubstr("does not declare"));
}

TEST(ArrayCodec, GivesBackNumbersOfEveryKindOfRepetition) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const std::uint8_t components = 1 + random() % 4;
    const std::uint32_t spread = trial % 3 == 0 ? ~0U : 1 + random() % 6000;
    std::vector<std::uint32_t> numbers(components * (random() % 400));
    std::uint32_t base = random();
    for (std::uint32_t& number : numbers) {
      if (random() % 5 == 0) base += random() % 3;
      number = base + random() % spread;
    }
    PayloadWriter record;
    ArrayView view = viewOf(numbers);
    view.components = components;
    putArray(record, view, 1);
    const auto array = arrayIn(record);
    ASSERT_TRUE(array) << array.error().message;
    EXPECT_TRUE(std::ranges::equal(array->bytes, view.bytes));
  }
}

TEST(ArrayCodec, StoresLongArraysInBlocks) {
  constexpr std::size_t kRows = 2 * t4d_layout::kBlockRows + 17;
  std::vector<std::uint32_t> numbers(2 * kRows);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::uint32_t>(i / 7);
  for (const int level : {0, 3}) {
    PayloadWriter record;
    ArrayView view = viewOf(numbers);
    view.components = 2;
    putArray(record, view, level);
    ASSERT_EQ(record.blocks().size(), 3u);
    if (level == 0) {
      EXPECT_EQ(record.blocks()[1].size(), 8 * t4d_layout::kBlockRows);
      EXPECT_EQ(record.blocks()[2].size(), 8u * 17);
    }
    const auto array = arrayIn(record);
    ASSERT_TRUE(array) << array.error().message;
    EXPECT_TRUE(std::ranges::equal(array->bytes, view.bytes));
  }
}

TEST(ArrayCodec, RefusesEveryTruncation) {
  const std::vector<double> numbers(50, 1.5);
  for (const int level : {0, 3}) {
    PayloadWriter record;
    putArray(record, viewOf(numbers), level);
    for (std::size_t length = 0; length < record.size(); ++length) {
      const PayloadView view = {record.bytes().first(length), record.view().blocks};
      PayloadReader from(view);
      EXPECT_FALSE(takeArray(from)) << length;
    }
    const auto block = record.view().blocks[0];
    for (std::size_t length = 0; length < block.size(); ++length) {
      const PayloadView view = {record.bytes(), {block.first(length)}};
      PayloadReader from(view);
      EXPECT_FALSE(takeArray(from)) << length;
    }
  }
}

TEST(ArrayCodec, RefusesClaimsBeforeItAllocates) {
  const std::uint64_t most = ~std::uint64_t{0};
  const std::string eight(8, '\0');
  // Rows times the size of a row would overflow to exactly the 8 bytes that are stored.
  EXPECT_THAT(faultOfRecord(recordOf(10, 1, 0, (most / 8) + 2, {eight})), HasSubstr("are left"));
  EXPECT_THAT(faultOfRecord(recordOf(10, 255, 0, most, {eight})), HasSubstr("are left"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, 65537, {eight})),
              HasSubstr("in 2 blocks; 1 are left"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, 8 * 1024 + 1, {eight})), HasSubstr("1024th"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, 1, {""})), HasSubstr("1024th"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 0, 7, {eight})), HasSubstr("is stored in 8"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 0, 7, {})), HasSubstr("0 are left"));
}

TEST(ArrayCodec, RefusesWhatTheHeaderCannotSay) {
  const std::string eight(8, '\0');
  EXPECT_EQ(faultOfRecord(recordOf(1, 8, 0, 1, {eight})), "");
  EXPECT_THAT(faultOfRecord(recordOf(0, 8, 0, 1, {eight})), HasSubstr("unknown number type 0"));
  EXPECT_THAT(faultOfRecord(recordOf(11, 8, 0, 1, {eight})), HasSubstr("unknown number type 11"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 0, 0, 8, {eight})), HasSubstr("rows of no numbers"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 8, 3, 1, {eight})), HasSubstr("unknown codec 3"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 8, 2, 1, {eight})), HasSubstr("codec 2"));
  EXPECT_THAT(faultOfRecord(recordOf(1, 1, 1, 0, {})), HasSubstr("no rows"));
  for (std::size_t at = 3; at < 8; ++at) {
    const PayloadWriter bad =
        withFields(recordOf(1, 8, 0, 1, {eight}), [&](auto& fields) { fields[at] = std::byte{1}; });
    EXPECT_THAT(faultOfRecord(bad), HasSubstr("reserved"));
  }
}

TEST(ArrayCodec, RefusesFramesThatAreNotExactlyTheArray) {
  const std::string frame = zstdOf(std::string(1000, 'x'));
  const auto fault = [&](std::uint64_t rows, const std::string& stored) {
    return faultOfRecord(recordOf(1, 1, 1, rows, {stored}));
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
}

TEST(Crc32c, HasItsCheckValueAndIsZeroOfNothing) {
  EXPECT_EQ(platform::crc32c("123456789", 9), 0xE3069283u);
  EXPECT_EQ(platform::crc32c("", 0), 0u);
  EXPECT_EQ(platform::crc32c("6789", 4, platform::crc32c("12345", 5)), 0xE3069283u);
  EXPECT_EQ(platform::crc32c(std::string(32, '\0').data(), 32), 0x8A9136AAu);  // RFC 3720, B.4
}

}  // namespace
}  // namespace t4d::formats
