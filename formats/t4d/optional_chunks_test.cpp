#include "formats/t4d/optional_chunks.h"

#include <gmock/gmock.h>

namespace t4d::formats {
namespace {

TEST(LostChunks, AreCountedByTheirTypesWithAllTheirBytes) {
  LostChunks lost;
  ChunkHeader header;
  header.type = {'A', 'b', 'c', 'D'};
  header.payloadBytes = 100;
  const std::uint64_t one = header.bytes();
  lost.add(header);
  header.payloadBytes = 300;
  lost.add(header);
  const std::uint64_t both = one + header.bytes();
  header.type = {'Z', 'b', 'c', 'D'};
  lost.add(header);
  const std::string rest =
      " bytes: by its type it is not safe to copy, so it may depend on what has changed";
  EXPECT_THAT(lost.lines(),
              testing::ElementsAre("2 chunks 'AbcD', " + std::to_string(both) + rest,
                                   "1 chunk 'ZbcD', " + std::to_string(header.bytes()) + rest));
}

}  // namespace
}  // namespace t4d::formats
