#include <sstream>

#include <gtest/gtest.h>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/test_slabs.h"
#include "t4d/check.h"
#include "tests/paths.h"

/// The examples in SPEC.md are what this code writes and reads.
namespace t4d::formats {
namespace {

/// The bytes of the first block of code after `heading`. Lines are "OFFSET  BYTES | what it is".
std::string bytesInSpec(const std::string& heading) {
  std::istringstream spec(platform::contents(T4D_SPEC));
  std::string line;
  while (std::getline(spec, line) && line != heading) {
  }
  while (std::getline(spec, line) && line != "```") {
  }
  std::string bytes;
  while (std::getline(spec, line) && line != "```") {
    std::istringstream columns(line.substr(0, line.find('|')));
    std::size_t offset = 0;
    columns >> std::hex >> offset;
    EXPECT_EQ(offset, bytes.size()) << line;
    for (unsigned byte = 0; columns >> std::hex >> byte;) bytes += static_cast<char>(byte);
  }
  return bytes;
}

std::string hexOf(const std::string& bytes) {
  std::ostringstream text;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    char byte[4];
    std::snprintf(byte, sizeof byte, "%02X", static_cast<unsigned char>(bytes[i]));
    text << byte << (i % 8 == 7 ? "\n" : " ");
  }
  return text.str();
}

TEST(Spec, MinimalFileIsWhatTheWriterWrites) {
  const auto path = temporaryPath("minimal.t4d");
  Metadata metadata;
  metadata.generator = "example";
  metadata.bodies = {{"simplex"}};
  auto writer = T4dWriter::create(path, metadata, {0, false, true});
  ASSERT_TRUE(writer && writer->body(0).put(simplexSlab()) && writer->finish());
  const std::string bytes = platform::contents(path);
  EXPECT_EQ(bytesInSpec("## A complete file"), bytes) << hexOf(bytes);

  auto reader = T4dReader::open(path);
  ASSERT_TRUE(reader) << reader.error().text();
  const auto report = measure::checkMesh(reader->body(0), {true});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(report->valid() && report->closed && report->oriented);
  EXPECT_EQ(report->hypervolume, 1.0 / 24);
}

/// The bytes of the lines of code after the line that ends with `before`.
std::vector<std::byte> codeInSpec(const std::string& before) {
  std::istringstream spec(platform::contents(T4D_SPEC));
  std::string line;
  while (std::getline(spec, line) && !line.ends_with(before)) {
  }
  std::getline(spec, line);
  std::vector<std::byte> bytes;
  while (std::getline(spec, line) && line.starts_with("    ")) {
    std::istringstream columns(line);
    for (std::string word; columns >> word && word.size() == 2;) {
      bytes.push_back(std::byte(std::stoul(word, nullptr, 16)));
    }
  }
  return bytes;
}

TEST(Spec, CompressedArrayIsReadAsItSays) {
  std::vector<std::uint16_t> expected;
  for (std::uint16_t i = 0; i < 24; ++i) expected.push_back(i + 0x0300);
  t4d_layout::PayloadWriter record;
  ArrayView view = viewOf(expected);
  view.components = 2;
  putArray(record, view, 3);
  const std::vector<std::byte> frame = codeInSpec("and the block may be this frame of 43 bytes:");
  ASSERT_EQ(frame.size(), 43u);
  const PackedArray packed = {model::ScalarType::UInt16, 2, 12, Codec::Zstd, {}};
  const std::span<const std::byte> block = frame;
  PackedArray stored = packed;
  stored.blocks = std::span(&block, 1);
  const auto array = unpack(stored);
  ASSERT_TRUE(array) << array.error().message;
  EXPECT_TRUE(std::ranges::equal(*array, std::as_bytes(std::span(expected))));
}

}  // namespace
}  // namespace t4d::formats
