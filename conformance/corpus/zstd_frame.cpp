#include "conformance/corpus/zstd_frame.h"

#include <algorithm>
#include <memory>

#include <zstd.h>

#include "conformance/corpus/record.h"

namespace t4d::conformance {
namespace {

constexpr std::uint32_t kMagic = 0xFD2FB528;
constexpr std::uint32_t kSkippableMagic = 0x184D2A50;

std::string littleEndian(std::uint64_t value, std::size_t bytes) {
  return bytesOf(value).substr(0, bytes);
}

std::string blocksOf(std::string_view content, std::size_t blockBytes) {
  enum Type : std::uint32_t { kStored = 0, kRun = 1 };
  std::string blocks;
  do {
    const std::string_view block = content.substr(0, blockBytes);
    content.remove_prefix(block.size());
    const bool run = block.size() > 1 && block.find_first_not_of(block[0]) == block.npos;
    const auto size = static_cast<std::uint32_t>(block.size());
    const std::uint32_t last = content.empty() ? 1 : 0;
    blocks += littleEndian(last | (run ? kRun : kStored) << 1 | size << 3, 3);
    blocks += run ? block.substr(0, 1) : block;
  } while (!content.empty());
  return blocks;
}

}  // namespace

std::string zstdFrame(std::string_view content, const FrameOptions& options) {
  const std::uint64_t size = options.declaredSize.value_or(content.size());
  const bool oneSegment = !options.windowLog;
  // The size in 1 byte (if there is no window), 2, 4 or 8.
  std::uint32_t sizeFlag = size < 256 ? 0 : size < 65536 + 256 ? 1 : size >> 32 == 0 ? 2 : 3;
  if (!oneSegment && sizeFlag == 0) sizeFlag = 2;
  if (!options.declareSize) sizeFlag = 0;
  const std::uint32_t dictionaryFlag = options.dictionaryId ? 3 : 0;  // 4 bytes, or none
  std::string frame = littleEndian(kMagic, 4);
  frame += littleEndian(sizeFlag << 6 | (oneSegment ? 1U : 0U) << 5 | dictionaryFlag, 1);
  if (options.windowLog) frame += littleEndian((*options.windowLog - 10U) << 3, 1);
  if (options.dictionaryId) frame += littleEndian(*options.dictionaryId, 4);
  if (options.declareSize) {
    frame += littleEndian(sizeFlag == 1 ? size - 256 : size, std::size_t{1} << sizeFlag);
  }
  return frame + blocksOf(content, options.blockBytes);
}

std::string zstdByLibrary(std::string_view content, bool checksum) {
  constexpr int kLevel = 19;
  constexpr std::size_t kDense = 256;
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                     &ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, checksum ? 1 : 0);
  std::string frame;
  const auto compress = [&] {
    frame.resize(ZSTD_compressBound(content.size()));
    frame.resize(
        ZSTD_compress2(context.get(), frame.data(), frame.size(), content.data(), content.size()));
  };
  compress();
  if (frame.size() * kDense < content.size()) {
    // A window of 1 KiB keeps any frame within the limit of rule A9.
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, 10);
    compress();
  }
  return frame;
}

unsigned zstdLibraryVersion() { return ZSTD_versionNumber(); }

std::string zstdSkippableFrame(std::string_view content) {
  return littleEndian(kSkippableMagic, 4) + littleEndian(content.size(), 4) + std::string(content);
}

}  // namespace t4d::conformance
