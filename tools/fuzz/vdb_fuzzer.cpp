#include <cmath>
#include <cstring>
#include <random>

#include <fmt/format.h>

#include "t4d/frames.h"
#include "tools/fuzz/fuzz.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t maxSize);

/// A .vdb file, read as a whole series, and twice as one of two frames.
namespace t4d::fuzz {
namespace {

// A byte is a child of a node at most, and a node of 32^3 children takes 64 KiB of masks.
constexpr std::size_t kMemoryPerFileByte = 256;
constexpr std::size_t kMemoryAlways = std::size_t{4} << 20;

void readFrames(const std::vector<std::filesystem::path>& files,
                const voxel4d::VdbFramesOptions& options) {
  auto frames = voxel4d::openVdbFrames(files, options);
  if (!frames) {
    must(!frames.error().message.empty(), "a refusal says what");
    return;
  }
  must((*frames)->frameCount() >= 2, "there are two frames or more");
  must((*frames)->lattice().voxelSize > 0, "voxels have a size");
  for (std::size_t i = 0; i < (*frames)->frameCount(); ++i) {
    const auto frame = (*frames)->frame(i);
    if (!frame) {
      must(!frame.error().message.empty() && !frame.error().where.empty(),
           "a refusal says what and where");
      return;
    }
    const auto checked = voxel4d::checkFrame(*frame);
    must(checked.has_value(), checked ? "" : checked.error().message.c_str());
  }
}

/// The number of points inside in the first frame of the grids named "solid"; many if it cannot be
/// read.
std::uint64_t pointsInside(const std::vector<std::filesystem::path>& files) {
  const auto frames = voxel4d::openVdbFrames(files, {.frameTime = 1, .grid = "solid"});
  if (!frames) return UINT64_MAX;
  const auto frame = (*frames)->frame(0);
  return frame ? voxel4d::countInside(*frame) : UINT64_MAX;
}

int test(std::span<const std::uint8_t> bytes) {
  static MemoryFile file;
  file.set(bytes);
  const HeapMeter heap;
  // The last byte selects level sets or densities.
  const bool density = !bytes.empty() && bytes.back() % 2 == 1;
  readFrames({file.path()}, {});
  readFrames({file.path(), file.path()},
             {.iso = density ? std::optional(0.5) : std::nullopt, .frameTime = 1});
  readFrames({file.path(), file.path()},
             {.frameTime = 1, .region = voxel4d::Region{{{{1, 12}, {-3, 9}, {0, 4}}}, {}}});
  must(heap.peak() <= kMemoryPerFileByte * bytes.size() + kMemoryAlways,
       fmt::format("reading {} bytes takes {} of memory", bytes.size(), heap.peak()));
  // What moves takes time for all about its surface, which tiles in few bytes can have.
  constexpr std::uint64_t kFewPoints = 1000;
  if (pointsInside({file.path(), file.path()}) < kFewPoints) {
    readFrames({file.path(), file.path()},
               {.frameTime = 0.01, .grid = "solid", .velocity = "v", .substeps = 2});
  }
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}

/// A small .vdb consists mostly of empty node masks, so most mutations are made near nonzero bytes.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed) {
  std::minstd_rand random(seed);
  std::vector<std::size_t> telling;
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] != 0) telling.push_back(i);
  }
  if (telling.empty() || random() % 8 == 0) return LLVMFuzzerMutate(data, size, maxSize);
  constexpr std::size_t kBefore = 8;
  constexpr std::size_t kLength = 32;
  const std::size_t at = telling[random() % telling.size()];
  const std::size_t begin = at < kBefore ? 0 : at - kBefore;
  const std::size_t length = std::min(kLength, size - begin);
  // Mutated in place; otherwise everything after it would move.
  std::uint8_t part[kLength];
  std::memcpy(part, data + begin, length);
  const std::size_t now = LLVMFuzzerMutate(part, length, length);
  if (random() % 8 != 0) {
    std::memcpy(data + begin, part, now);
    return size;
  }
  std::memmove(data + begin + now, data + begin + length, size - begin - length);
  std::memcpy(data + begin, part, now);
  return size - length + now;
}
