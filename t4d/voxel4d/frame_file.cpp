#include "t4d/voxel4d/frame_file.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace t4d::voxel4d {
namespace {

constexpr std::size_t kPoints = std::tuple_size_v<FrameFile::Buffer>;

}  // namespace

Result<std::unique_ptr<FrameFile>> FrameFile::create(const Frame& frame, std::size_t largeFrame) {
  const std::size_t valueSize = valueSizeOf(frame);
  if (valueSize == 0 || valueSize * kPoints * frame.blocks.size() < largeFrame) return nullptr;
  auto file = system::ScratchFile::create();
  if (!file) return pass(file.error());
  return std::unique_ptr<FrameFile>(new FrameFile(std::move(*file), valueSize));
}

Result<void> FrameFile::addFractions(std::span<const double> fractions) {
  bytesOfFractions_ += fractions.size_bytes();
  return file_.append(std::as_bytes(fractions));
}

Result<void> FrameFile::takeValues(Frame& frame) {
  constexpr std::size_t kBlocksAtOnce = 256;
  std::vector<std::byte> together;
  for (std::size_t i = 0; i < frame.blocks.size(); ++i) {
    BlockValues& values = frame.blocks[i].values;
    const auto bytes = values.floats != nullptr ? std::as_bytes(std::span(values.floats, kPoints))
                                                : std::as_bytes(std::span(values.doubles, kPoints));
    together.insert(together.end(), bytes.begin(), bytes.end());
    values.floats = nullptr;
    values.doubles = nullptr;
    if ((i + 1) % kBlocksAtOnce != 0 && i + 1 < frame.blocks.size()) continue;
    if (auto added = file_.append(together); !added) return added;
    together.clear();
  }
  frame.owner.reset();
  return {};
}

void FrameFile::fractions(std::uint32_t first, std::span<double> into) const {
  read(std::uint64_t{first} * sizeof(double), std::as_writable_bytes(into));
}

BlockValues FrameFile::values(std::uint32_t block, BlockValues left, Buffer& buffer) const {
  const auto bytes = std::as_writable_bytes(std::span(buffer)).first(kPoints * valueSize_);
  read(bytesOfFractions_ + std::uint64_t{block} * bytes.size(), bytes);
  if (valueSize_ == sizeof(double)) {
    left.doubles = buffer.data();
  } else {
    left.floats = reinterpret_cast<const float*>(buffer.data());
  }
  return left;
}

void FrameFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  if (file_.read(offset, into)) return;
  std::ranges::fill(into, std::byte{0});
  whole_ = false;
}

}  // namespace t4d::voxel4d
