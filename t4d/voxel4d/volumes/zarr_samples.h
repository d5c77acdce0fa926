#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "t4d/model/error.h"
#include "t4d/voxel4d/volumes/sample_reader.h"
#include "t4d/voxel4d/volumes/zarr_array.h"
#include "t4d/voxel4d/volumes/zarr_store.h"

namespace t4d::voxel4d {

/// Chunks without a file: their samples have the fill value.
struct ZarrCounts {
  std::atomic<std::uint64_t> chunks = 0;
  std::atomic<std::uint64_t> missing = 0;
};

/// One channel of an array of Zarr.
struct ZarrSamples {
  std::shared_ptr<const ZarrStore> store;
  ZarrArray array;
  std::string axes;  ///< what each axis of the array is: x, y, z, t or c
  std::uint64_t channel = 0;
  std::shared_ptr<ZarrCounts> counts = std::make_shared<ZarrCounts>();
};

/// What is read along an axis.
struct ZarrRange {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// Reads what is in the ranges, one for each axis of the array (that of the channel is ignored): a
/// frame after another, each with its axes in the order of the samples in a chunk (`spaceAxes`). Of
/// chunks that hold several frames as many of these are kept as 256 MiB hold, and the chunks are
/// read again for the others.
std::unique_ptr<SampleReader> openZarrSamples(std::shared_ptr<const ZarrSamples> samples,
                                              std::vector<ZarrRange> ranges);
/// All of the channel.
std::unique_ptr<SampleReader> openZarrSamples(std::shared_ptr<const ZarrSamples> samples);

/// The axes of space from that which varies fastest in a chunk on.
std::string spaceAxes(const ZarrSamples& samples);

/// "" if each chunk had a file.
std::string zarrNotice(const ZarrCounts& counts);

}  // namespace t4d::voxel4d
