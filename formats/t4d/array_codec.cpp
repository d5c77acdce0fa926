#include "formats/t4d/array_codec.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <zstd.h>

#include "formats/t4d/first_error.h"
#include "model/parallel.h"

namespace t4d::formats {
namespace {

using t4d_layout::blockCount;
using t4d_layout::Features;
using t4d_layout::kBlockRows;
using t4d_layout::PayloadReader;
using t4d_layout::PayloadWriter;

constexpr std::size_t kTile = 64;  // rows at a time, so that both sides stay in cache

using Bytes = std::vector<std::byte>;

/// The first byte of every row, then the second byte of every row, and so on. This groups bytes
/// that vary little, such as signs and exponents.
void transpose(std::span<const std::byte> from, std::size_t rowBytes, std::byte* into) {
  const std::size_t rows = from.size() / rowBytes;
  for (std::size_t begin = 0; begin < rows; begin += kTile) {
    const std::size_t end = std::min(rows, begin + kTile);
    for (std::size_t column = 0; column < rowBytes; ++column) {
      std::byte* plane = into + column * rows;
      for (std::size_t row = begin; row < end; ++row) plane[row] = from[row * rowBytes + column];
    }
  }
}

void transposeBack(std::span<const std::byte> from, std::size_t rowBytes, std::byte* into) {
  const std::size_t rows = from.size() / rowBytes;
  for (std::size_t begin = 0; begin < rows; begin += kTile) {
    const std::size_t end = std::min(rows, begin + kTile);
    for (std::size_t column = 0; column < rowBytes; ++column) {
      const std::byte* plane = from.data() + column * rows;
      for (std::size_t row = begin; row < end; ++row) into[row * rowBytes + column] = plane[row];
    }
  }
}

std::uint32_t numberAt(std::span<const std::byte> bytes, std::size_t index) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + index * sizeof number, sizeof number);
  return number;
}

/// What a thread needs for a block, kept from one to the next: fresh memory of these sizes costs
/// more than what is done with it.
struct Workspace {
  Bytes rows;
  Bytes content;
  std::vector<std::uint32_t> others;
  Bytes frame;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context{ZSTD_createCCtx(), &ZSTD_freeCCtx};

  static Workspace& ofThread() {
    thread_local Workspace own;
    return own;
  }
};

/// The first `size` elements of a buffer, which grows if it must.
template <class T>
std::span<T> firstOf(std::vector<T>& buffer, std::size_t size) {
  if (buffer.size() < size) buffer.resize(size);
  return std::span(buffer).first(size);
}

/// The content of a frame of codec 2: for each number how many places before it the same number
/// stands, at most `farthest`, transposed; then, for those where this is 0, the difference to the
/// last such number.
///
/// Only the last number of each remainder is looked up, so a repeated number may be missed where
/// two numbers share one; that costs a few bytes and no correctness.
///
/// `Components` is the number of components of a row, or a constant of it.
template <class Components>
std::span<const std::byte> repeatsOf(std::span<const std::byte> from, Components components,
                                     std::uint32_t farthest, Workspace& work) {
  constexpr std::uint32_t kSlots = 4096;
  // Where a number was seen last, counted from 1, in the upper half, and the number in the lower.
  std::array<std::uint64_t, kSlots> seen;
  // No number of a slot equals what it starts with.
  for (std::uint32_t slot = 0; slot < kSlots; ++slot) seen[slot] = slot + 1;
  const std::size_t count = from.size() / sizeof(std::uint32_t);
  const std::size_t rows = count / components;
  const auto content = firstOf(work.content, count + from.size());
  std::uint32_t* const others = firstOf(work.others, count + 1).data();
  std::size_t otherCount = 0;
  std::size_t i = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < components; ++k) {
      const std::uint32_t number = numberAt(from, i++);
      std::uint64_t& slot = seen[number % kSlots];
      const std::uint64_t here = std::uint64_t{i} << 32U | number;
      // The way back if the numbers are the same; if not, beyond 32 bits.
      const std::uint64_t back = std::rotr(here - slot, 32);
      // No branches: whether a number repeats another is hard to predict.
      const bool repeats = back <= farthest;
      content[k * rows + row] = static_cast<std::byte>(repeats ? back : 0);
      others[otherCount] = number;
      otherCount += repeats ? 0 : 1;
      slot = here;
    }
  }
  std::uint32_t last = 0;
  for (std::uint32_t& other : std::span(others, otherCount)) {
    const std::uint32_t step = other - std::exchange(last, other);
    other = step << 1U ^ (step >> 31U != 0 ? ~0U : 0U);
  }
  transpose(std::as_bytes(std::span(others, otherCount)), sizeof(std::uint32_t),
            content.data() + count);
  return content.first(count + otherCount * sizeof(std::uint32_t));
}

Result<void> numbersOfRepeats(std::span<const std::byte> content, std::size_t components,
                              std::span<std::byte> into) {
  const std::size_t count = into.size() / sizeof(std::uint32_t);
  const std::size_t rows = count / components;
  const std::size_t otherCount = (content.size() - count) / sizeof(std::uint32_t);
  std::vector<std::uint32_t> others(otherCount);
  transposeBack(content.subspan(count), sizeof(std::uint32_t),
                reinterpret_cast<std::byte*>(others.data()));
  std::size_t used = 0;
  std::uint32_t last = 0;
  for (std::size_t row = 0, i = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < components; ++k, ++i) {
      const auto back = static_cast<std::size_t>(content[k * rows + row]);
      std::byte* const at = into.data() + i * sizeof(std::uint32_t);
      if (back > i) {
        return invalid(fmt::format("number {} of a block repeats one before the first", i));
      }
      if (back > 0) {
        std::memcpy(at, at - back * sizeof(std::uint32_t), sizeof(std::uint32_t));
        continue;
      }
      if (used == otherCount) return invalid("a block lacks numbers that repeat no other");
      const std::uint32_t zigzag = others[used++];
      last += zigzag >> 1U ^ ((zigzag & 1U) != 0 ? ~0U : 0U);
      std::memcpy(at, &last, sizeof last);
    }
  }
  if (used != otherCount) {
    return invalid(
        fmt::format("a block has {} numbers that repeat no other, and needs {}", otherCount, used));
  }
  return {};
}

/// One zstd frame; empty if zstd fails. A `windowLog` of 0 means the level's default.
std::span<const std::byte> zstdFrame(std::span<const std::byte> bytes, int level, int windowLog,
                                     Workspace& work) {
  const auto frame = firstOf(work.frame, ZSTD_compressBound(bytes.size()));
  ZSTD_CCtx* const context = work.context.get();
  ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setParameter(context, ZSTD_c_windowLog, windowLog);
  const std::size_t size =
      ZSTD_compress2(context, frame.data(), frame.size(), bytes.data(), bytes.size());
  return ZSTD_isError(size) != 0 ? std::span<const std::byte>() : frame.first(size);
}

/// An array to be stored, and where its blocks come from.
struct ArrayRows {
  model::ScalarType type;
  std::uint8_t components;
  std::uint64_t count;
  /// The rows of a block; `space` is theirs to use.
  std::function<std::span<const std::byte>(std::size_t block, Bytes& space)> block;
  bool isMany = false;

  std::size_t rowBytes() const { return model::scalarSize(type) * components; }
  std::uint64_t bytes() const { return count * rowBytes(); }
};

/// How a block of repeats is sought and compressed.
struct RepeatsEffort {
  std::uint32_t farthest = 255;
  int level;

  /// In blocks of many numbers, such as the cells of a woven slab, references to numbers far back
  /// are no more regular than differences are. Without them, zstd at level 1 makes about as few
  /// bytes (1 to 4 % more) as it makes with them at level 3, in half the time.
  static RepeatsEffort of(const ArrayRows& array, std::size_t numbers, int level) {
    constexpr std::size_t kMany = std::size_t{1} << 17;
    constexpr int kUsualLevel = 3;
    if (!array.isMany || numbers < kMany || level > kUsualLevel) return {.level = level};
    return {.farthest = 96, .level = 1};
  }
};

/// One block in a zstd frame.
Bytes compressedBlock(std::span<const std::byte> rows, const ArrayRows& array, Codec codec,
                      int level) {
  Workspace& work = Workspace::ofThread();
  std::span<const std::byte> content;
  if (codec == Codec::Repeats) {
    const auto effort = RepeatsEffort::of(array, rows.size() / sizeof(std::uint32_t), level);
    level = effort.level;
    constexpr std::integral_constant<std::size_t, 4> kCell;
    content = array.components == kCell
                  ? repeatsOf(rows, kCell, effort.farthest, work)
                  : repeatsOf(rows, std::size_t{array.components}, effort.farthest, work);
  } else {
    const auto transposed = firstOf(work.content, rows.size());
    transpose(rows, array.rowBytes(), transposed.data());
    content = transposed;
  }
  auto frame = zstdFrame(content, level, 0, work);
  if (frame.size() * t4d_layout::kMaxExpansion < rows.size()) {
    // A block of zstd holds at most one window and takes at least 4 bytes, and a byte of content
    // stands for up to four of the array: 4 KiB or 1 KiB stays within the limit.
    const int windowLog = codec == Codec::Repeats ? 10 : 12;
    frame = zstdFrame(content, level, windowLog, work);
  }
  Bytes block(frame.begin(), frame.end());
  // Rows of many numbers are rare: the memory for them is not kept.
  constexpr std::size_t kMostKept = std::size_t{4} << 20;
  if (rows.size() > kMostKept) work.content = work.frame = {};
  return block;
}

/// The blocks of an array as they are made: those after the first few megabytes wait in a file.
class WaitingBlocks {
 public:
  explicit WaitingBlocks(std::uint64_t count) : blocks_(count) {}

  /// Several threads may call it at a time.
  void set(std::size_t i, Bytes bytes) {
    constexpr std::uint64_t kMostInMemory = std::uint64_t{4} << 20;
    blocks_[i] = StoredBlock(std::move(bytes));
    if ((total_ += blocks_[i].size()) > kMostInMemory) blocks_[i].moveTo(file_);
  }

  std::uint64_t bytes() const { return total_; }
  std::vector<StoredBlock>& blocks() { return blocks_; }

 private:
  std::vector<StoredBlock> blocks_;
  std::shared_ptr<BlockFile> file_ = std::make_shared<BlockFile>();
  std::atomic<std::uint64_t> total_ = 0;
};

/// The blocks of an array, compressed; empty if they are not smaller than the array.
std::vector<StoredBlock> compressed(const ArrayRows& array, Codec codec, int level) {
  WaitingBlocks made(blockCount(array.count));
  std::atomic<bool> failed = false;
  model::forEach(made.blocks().size(), [&](std::size_t i) {
    const auto rows = array.block(i, Workspace::ofThread().rows);
    Bytes block = compressedBlock(rows, array, codec, level);
    if (block.empty()) failed = true;
    made.set(i, std::move(block));
  });
  if (failed || made.bytes() >= array.bytes()) return {};
  return std::move(made.blocks());
}

std::vector<StoredBlock> uncompressed(const ArrayRows& array) {
  WaitingBlocks made(blockCount(array.count));
  for (std::size_t i = 0; i < made.blocks().size(); ++i) {
    const auto rows = array.block(i, Workspace::ofThread().rows);
    made.set(i, Bytes(rows.begin(), rows.end()));
  }
  return std::move(made.blocks());
}

void putRows(PayloadWriter& into, const ArrayRows& array, int level) {
  std::vector<StoredBlock> blocks;
  auto codec = Codec::Raw;
  if (level > 0 && array.count > 0) {
    codec = array.type == model::ScalarType::UInt32 ? Codec::Repeats : Codec::Zstd;
    blocks = compressed(array, codec, level);
  }
  if (blocks.empty()) {
    codec = Codec::Raw;
    blocks = uncompressed(array);
  }
  into.put(static_cast<std::uint8_t>(array.type));
  into.put(array.components);
  into.put(static_cast<std::uint8_t>(codec));
  into.put(std::uint8_t{0});
  into.put(std::uint32_t{0});
  into.put(array.count);
  for (StoredBlock& block : blocks) into.putBlock(std::move(block));
}

/// The content of a zstd frame, which has to declare a size from `least` to `most` bytes.
Result<Bytes> decompressed(std::span<const std::byte> stored, std::uint64_t least,
                           std::uint64_t most) {
  // The library may accept frames from before the standard, and skips skippable frames.
  std::uint32_t magic = 0;
  if (stored.size() >= sizeof magic) std::memcpy(&magic, stored.data(), sizeof magic);
  if (magic != ZSTD_MAGICNUMBER ||
      ZSTD_findFrameCompressedSize(stored.data(), stored.size()) != stored.size()) {
    return invalid("a compressed block is not one whole zstd frame");
  }
  const std::uint64_t size = ZSTD_getFrameContentSize(stored.data(), stored.size());
  if (size < least || size > most) {
    return invalid(
        fmt::format("a compressed block does not declare {} bytes, as its rows need",
                    least == most ? std::to_string(least) : fmt::format("{} to {}", least, most)));
  }
  Bytes content(size);
  const std::size_t got =
      ZSTD_decompress(content.data(), content.size(), stored.data(), stored.size());
  if (ZSTD_isError(got) != 0 || got != size) {
    return invalid(fmt::format("a compressed block cannot be decompressed: {}",
                               ZSTD_isError(got) != 0 ? ZSTD_getErrorName(got) : "too short"));
  }
  return content;
}

Result<void> unpackStored(const PackedArray& array, std::span<const std::byte> stored,
                          std::span<std::byte> into) {
  if (array.codec == Codec::Raw) {
    std::copy(stored.begin(), stored.end(), into.begin());
    return {};
  }
  if (array.codec == Codec::Zstd) {
    const auto content = decompressed(stored, into.size(), into.size());
    if (!content) return content.error();
    transposeBack(*content, array.rowBytes(), into.data());
    return {};
  }
  // A byte for each number, and at most the number itself.
  const std::uint64_t numbers = into.size() / sizeof(std::uint32_t);
  const auto content = decompressed(stored, numbers, numbers + into.size());
  if (!content) return content.error();
  if ((content->size() - numbers) % sizeof(std::uint32_t) != 0) {
    return invalid("the numbers of a block that repeat no other are not whole");
  }
  return numbersOfRepeats(*content, array.components, into);
}

/// Checks the sizes of an array's blocks against its rows.
Result<void> checkBlocks(const PackedArray& array) {
  std::uint64_t left = array.rows;
  for (const auto& block : array.blocks) {
    const std::uint64_t size = std::min(left, kBlockRows) * array.rowBytes();
    left -= std::min(left, kBlockRows);
    if (array.codec == Codec::Raw && block.size() != size) {
      return invalid(fmt::format("a block of {} bytes is stored in {}", size, block.size()));
    }
    if (size > block.size() * t4d_layout::kMaxExpansion) {
      return invalid(fmt::format("a block of {} bytes is stored in {}; at least a {}th is needed",
                                 size, block.size(), t4d_layout::kMaxExpansion));
    }
  }
  return {};
}

}  // namespace

void putArray(PayloadWriter& into, const ArrayView& array, int level) {
  const std::size_t blockBytes = kBlockRows * array.rowBytes();
  const auto block = [&](std::size_t i, Bytes& /*space*/) {
    const auto from = array.bytes.subspan(i * blockBytes);
    return from.first(std::min(blockBytes, from.size()));
  };
  putRows(
      into,
      {array.type, array.components, array.bytes.size() / array.rowBytes(), block, array.isMany},
      level);
}

void putArray(PayloadWriter& into, const MadeArray& array, int level) {
  const std::size_t rowBytes = model::scalarSize(array.type) * array.components;
  const auto block = [&](std::size_t i, Bytes& space) -> std::span<const std::byte> {
    const std::uint64_t first = i * kBlockRows;
    const auto rows = firstOf(space, std::min(kBlockRows, array.rows - first) * rowBytes);
    // A thread that waits here must not begin another block, which would use the same memory.
    model::isolate([&] { array.make(first, rows); });
    return rows;
  };
  putRows(into, {array.type, array.components, array.rows, block, array.isMany}, level);
}

Result<PackedArray> takePacked(PayloadReader& from, const Features& features) {
  PackedArray array;
  const auto type = from.take<std::uint8_t>();
  array.type = static_cast<model::ScalarType>(type);
  array.components = from.take<std::uint8_t>();
  const auto codec = from.take<std::uint8_t>();
  const auto reserved = from.take<std::uint8_t>() | from.take<std::uint32_t>();
  array.rows = from.take<std::uint64_t>();
  if (from.overrun()) return invalid("an array's record is truncated");
  const std::size_t scalar = model::scalarSize(array.type);
  if (scalar == 0) return invalid(fmt::format("an array has the unknown number type {}", type));
  if (array.components == 0) return invalid("an array has rows of no numbers");
  if (codec > static_cast<std::uint8_t>(Codec::Repeats)) {
    return invalid(fmt::format("an array has the unknown codec {}", codec));
  }
  array.codec = static_cast<Codec>(codec);
  if (array.rows == 0 && array.codec != Codec::Raw) {
    return invalid(fmt::format("an array of no rows has codec {}", codec));
  }
  if (array.codec == Codec::Repeats && array.type != model::ScalarType::UInt32) {
    return invalid(fmt::format("an array of type {} has codec 2, which is for type 5", type));
  }
  if (reserved != 0) return invalid("an array's reserved bytes are not zero");
  if (array.codec != Codec::Raw && !features.zstd) {
    return invalid("an array is compressed with zstd, a feature that the file does not name");
  }
  const std::uint64_t blocks = blockCount(array.rows);
  if (blocks > from.blocksLeft()) {
    return invalid(fmt::format("an array of {} rows is in {} blocks; {} are left", array.rows,
                               blocks, from.blocksLeft()));
  }
  array.blocks = from.takeBlocks(blocks);
  if (auto checked = checkBlocks(array); !checked) return checked.error();
  return array;
}

Result<void> unpackBlock(const PackedArray& array, std::size_t block, std::span<std::byte> into) {
  return unpackStored(array, array.blocks[block], into);
}

Result<std::vector<std::byte>> unpack(const PackedArray& array) {
  Bytes bytes(array.rows * array.rowBytes());
  if (auto unpacked = unpack(array, bytes); !unpacked) return unpacked.error();
  return bytes;
}

Result<void> unpack(const PackedArray& array, std::span<std::byte> into) {
  const std::size_t blockBytes = kBlockRows * array.rowBytes();
  FirstError error;
  model::forEach(array.blocks.size(), [&](std::size_t i) {
    const auto rest = into.subspan(i * blockBytes);
    error.add(i, unpackBlock(array, i, rest.first(std::min(rest.size(), blockBytes))));
  });
  return error.result();
}

Result<void> checkArray(const PackedArray& array, model::ScalarType type, std::uint8_t components) {
  if (array.type == type && array.components == components) return {};
  return invalid(fmt::format(
      "an array has rows of {} numbers of type {}, where {} of type {} are "
      "expected",
      array.components, static_cast<int>(array.type), components, static_cast<int>(type)));
}

Result<Array> takeArray(PayloadReader& from, const Features& features) {
  auto packed = takePacked(from, features);
  if (!packed) return packed.error();
  auto bytes = unpack(*packed);
  if (!bytes) return bytes.error();
  return Array{packed->type, packed->components, packed->rows, std::move(*bytes)};
}

Result<Array> takeArrayOf(PayloadReader& from, model::ScalarType type, std::uint8_t components,
                          const Features& features) {
  auto packed = takePacked(from, features);
  if (!packed) return packed.error();
  if (auto fits = checkArray(*packed, type, components); !fits) return fits.error();
  auto bytes = unpack(*packed);
  if (!bytes) return bytes.error();
  return Array{packed->type, packed->components, packed->rows, std::move(*bytes)};
}

}  // namespace t4d::formats
