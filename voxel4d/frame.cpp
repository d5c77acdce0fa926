#include <algorithm>
#include <bit>
#include <utility>

#include <fmt/format.h>

#include "t4d/frames.h"
#include "voxel4d/frame_file.h"

namespace t4d::voxel4d {

Place FrameSource::placeOf(std::size_t index) const {
  return placeIn({}, fmt::format("frame {}", index));
}

BlockValues valuesOf(const Frame& frame, std::size_t i, ValueBuffer& buffer) {
  const Block& block = frame.blocks[i];
  BlockValues values = block.values;
  if (!frame.file) return values;
  const auto bytes =
      std::as_writable_bytes(std::span(buffer)).first(buffer.size() * frame.valueSizeInFile);
  frame.file->read(std::uint64_t{block.inFile} * bytes.size(), bytes);
  if (frame.valueSizeInFile == sizeof(double)) {
    values.doubles = buffer.data();
  } else {
    values.floats = reinterpret_cast<const float*>(buffer.data());
  }
  return values;
}

Result<void> moveValuesToFile(Frame& frame) {
  auto file = FrameFile::create();
  if (!file) return file.error();
  const std::size_t valueSize = valueSizeOf(frame);
  constexpr std::size_t kBlocksAtOnce = 256;
  std::vector<std::byte> together;
  for (std::uint32_t i = 0; i < frame.blocks.size(); ++i) {
    Block& block = frame.blocks[i];
    block.inFile = i;
    constexpr std::size_t kPoints = std::tuple_size_v<ValueBuffer>;
    const auto bytes = block.values.floats != nullptr
                           ? std::as_bytes(std::span(block.values.floats, kPoints))
                           : std::as_bytes(std::span(block.values.doubles, kPoints));
    together.insert(together.end(), bytes.begin(), bytes.end());
    block.values.floats = nullptr;
    block.values.doubles = nullptr;
    if ((i + 1) % kBlocksAtOnce != 0 && i + 1 < frame.blocks.size()) continue;
    if (auto added = (*file)->append(together); !added) return added;
    together.clear();
  }
  frame.file = std::move(*file);
  frame.valueSizeInFile = valueSize;
  frame.owner.reset();
  return {};
}

std::size_t valueSizeOf(const Frame& frame) {
  if (frame.file) return frame.valueSizeInFile;
  const auto sizeOf = [](const Block& block) -> std::size_t {
    if (block.values.floats != nullptr) return sizeof(float);
    return block.values.doubles != nullptr ? sizeof(double) : 0;
  };
  const std::size_t size = frame.blocks.empty() ? 0 : sizeOf(frame.blocks.front());
  const auto isAlike = [&](const Block& block) { return sizeOf(block) == size; };
  return std::ranges::all_of(frame.blocks, isAlike) ? size : 0;
}

std::uint64_t countInside(const Frame& frame) {
  std::uint64_t count = 0;
  for (const Block& block : frame.blocks) {
    for (const std::uint64_t word : block.inside) count += std::popcount(word);
  }
  for (const InsideTile& tile : frame.tiles) {
    const auto points = static_cast<std::uint64_t>(tile.size) * kBlockSize;
    count += points * points * points;
  }
  return count;
}

}  // namespace t4d::voxel4d
