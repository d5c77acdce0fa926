#include "t4d/formats/t4d/array_codec.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include <fmt/format.h>
#include <zstd.h>

namespace t4d::formats {
namespace {

using t4d_layout::ByteReader;
using t4d_layout::ByteWriter;
using t4d_layout::Features;

constexpr std::size_t kBlock = 64;  // rows at a time, so that both sides stay in cache

void transpose(std::span<const std::byte> from, std::size_t rowBytes, std::byte* into) {
  const std::size_t rows = from.size() / rowBytes;
  for (std::size_t begin = 0; begin < rows; begin += kBlock) {
    const std::size_t end = std::min(rows, begin + kBlock);
    for (std::size_t column = 0; column < rowBytes; ++column) {
      std::byte* plane = into + column * rows;
      for (std::size_t row = begin; row < end; ++row) plane[row] = from[row * rowBytes + column];
    }
  }
}

void transposeBack(std::span<const std::byte> from, std::size_t rowBytes, std::byte* into) {
  const std::size_t rows = from.size() / rowBytes;
  for (std::size_t begin = 0; begin < rows; begin += kBlock) {
    const std::size_t end = std::min(rows, begin + kBlock);
    for (std::size_t column = 0; column < rowBytes; ++column) {
      const std::byte* plane = from.data() + column * rows;
      for (std::size_t row = begin; row < end; ++row) into[row * rowBytes + column] = plane[row];
    }
  }
}

/// One zstd frame; empty if zstd fails. A `windowLog` of 0 means the level's default.
std::vector<std::byte> zstdFrame(std::span<const std::byte> bytes, int level, int windowLog) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                     &ZSTD_freeCCtx);
  std::vector<std::byte> frame(ZSTD_compressBound(bytes.size()));
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, windowLog);
  const std::size_t size =
      ZSTD_compress2(context.get(), frame.data(), frame.size(), bytes.data(), bytes.size());
  frame.resize(ZSTD_isError(size) != 0 ? 0 : size);
  return frame;
}

std::vector<std::byte> compressed(const ArrayView& array, int level) {
  std::vector<std::byte> transposed(array.bytes.size());
  transpose(array.bytes, array.rowBytes(), transposed.data());
  std::vector<std::byte> frame = zstdFrame(transposed, level, 0);
  if (frame.size() * t4d_layout::kMaxExpansion < transposed.size()) {
    // A block holds at most one window and takes at least 4 bytes, so 4 KiB stays within the limit.
    constexpr int kSmallWindowLog = 12;
    frame = zstdFrame(transposed, level, kSmallWindowLog);
  }
  return frame;
}

Result<std::vector<std::byte>> decompressed(std::span<const std::byte> stored, std::size_t rowBytes,
                                            std::uint64_t size) {
  // The library may accept frames from before the standard, and skips skippable frames.
  std::uint32_t magic = 0;
  if (stored.size() >= sizeof magic) std::memcpy(&magic, stored.data(), sizeof magic);
  if (magic != ZSTD_MAGICNUMBER ||
      ZSTD_findFrameCompressedSize(stored.data(), stored.size()) != stored.size()) {
    return invalid("a compressed array is not one whole zstd frame");
  }
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != size) {
    return invalid(
        fmt::format("a compressed array does not declare the {} bytes of its rows", size));
  }
  std::vector<std::byte> transposed(size);
  const std::size_t got =
      ZSTD_decompress(transposed.data(), transposed.size(), stored.data(), stored.size());
  if (ZSTD_isError(got) != 0 || got != size) {
    return invalid(fmt::format("a compressed array cannot be decompressed: {}",
                               ZSTD_isError(got) != 0 ? ZSTD_getErrorName(got) : "too short"));
  }
  std::vector<std::byte> bytes(size);
  transposeBack(transposed, rowBytes, bytes.data());
  return bytes;
}

}  // namespace

void putArray(ByteWriter& into, const ArrayView& array, int level) {
  std::span<const std::byte> stored = array.bytes;
  std::vector<std::byte> smaller;
  auto codec = Codec::Raw;
  if (level > 0 && !array.bytes.empty()) {
    smaller = compressed(array, level);
    if (!smaller.empty() && smaller.size() < array.bytes.size()) {
      stored = smaller;
      codec = Codec::Zstd;
    }
  }
  into.put(static_cast<std::uint8_t>(array.type));
  into.put(array.components);
  into.put(static_cast<std::uint8_t>(codec));
  into.put(std::uint8_t{0});
  into.put(std::uint32_t{0});
  into.put(std::uint64_t{array.bytes.size() / array.rowBytes()});
  into.put(std::uint64_t{stored.size()});
  into.putBytes(stored.data(), stored.size());
  into.pad();
}

Result<PackedArray> takePacked(ByteReader& from, Features features) {
  PackedArray array;
  const auto type = from.take<std::uint8_t>();
  array.type = static_cast<model::ScalarType>(type);
  array.components = from.take<std::uint8_t>();
  const auto codec = from.take<std::uint8_t>();
  const auto reserved = from.take<std::uint8_t>() | from.take<std::uint32_t>();
  array.rows = from.take<std::uint64_t>();
  const auto storedBytes = from.take<std::uint64_t>();
  if (from.overrun()) return invalid("an array's header is truncated");
  const std::size_t scalar = model::scalarSize(array.type);
  if (scalar == 0) return invalid(fmt::format("an array has the unknown number type {}", type));
  if (array.components == 0) return invalid("an array has rows of no numbers");
  if (codec > static_cast<std::uint8_t>(Codec::Zstd)) {
    return invalid(fmt::format("an array has the unknown codec {}", codec));
  }
  if (reserved != 0) return invalid("an array's reserved bytes are not zero");
  if (codec == static_cast<std::uint8_t>(Codec::Zstd) && !features.zstd) {
    return invalid("an array is compressed with zstd, a feature that the file does not name");
  }
  if (storedBytes > from.left()) {
    return invalid(
        fmt::format("an array claims {} stored bytes where {} are left", storedBytes, from.left()));
  }
  array.codec = static_cast<Codec>(codec);
  const std::size_t rowBytes = array.rowBytes();
  const std::uint64_t limit =
      array.codec == Codec::Raw ? storedBytes : storedBytes * t4d_layout::kMaxExpansion;
  if (array.rows > limit / rowBytes) {
    return invalid(
        fmt::format("an array claims {} rows of {} bytes, more than its {} stored bytes "
                    "can hold",
                    array.rows, rowBytes, storedBytes));
  }
  const std::uint64_t size = array.rows * rowBytes;
  if (size == 0 && (storedBytes != 0 || array.codec != Codec::Raw)) {
    return invalid(
        fmt::format("an array of no rows is stored by codec {} in {} bytes", codec, storedBytes));
  }
  array.stored = from.takeBytes(storedBytes);
  if (!from.skipPadding()) return invalid("an array's padding is truncated or not zero");
  if (array.codec == Codec::Raw && storedBytes != size) {
    return invalid(fmt::format("an array of {} bytes is stored in {}", size, storedBytes));
  }
  return array;
}

Result<std::vector<std::byte>> unpack(const PackedArray& array) {
  if (array.codec == Codec::Raw) {
    return std::vector<std::byte>(array.stored.begin(), array.stored.end());
  }
  return decompressed(array.stored, array.rowBytes(), array.rows * array.rowBytes());
}

Result<Array> takeArray(ByteReader& from, Features features) {
  auto packed = takePacked(from, features);
  if (!packed) return pass(packed.error());
  auto bytes = unpack(*packed);
  if (!bytes) return pass(bytes.error());
  return Array{packed->type, packed->components, packed->rows, std::move(*bytes)};
}

Result<Array> takeArrayOf(ByteReader& from, model::ScalarType type, std::uint8_t components,
                          Features features) {
  auto array = takeArray(from, features);
  if (array && (array->type != type || array->components != components)) {
    return invalid(fmt::format(
        "an array has rows of {} numbers of type {}, where {} of type {} are "
        "expected",
        array->components, static_cast<int>(array->type), components, static_cast<int>(type)));
  }
  return array;
}

}  // namespace t4d::formats
