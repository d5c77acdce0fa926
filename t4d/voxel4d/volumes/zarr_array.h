#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "t4d/model/error.h"
#include "t4d/voxel4d/sample_type.h"
#include "t4d/voxel4d/volumes/zarr_codec.h"
#include "t4d/voxel4d/volumes/zarr_store.h"

namespace t4d::voxel4d {

/// Files that each hold many chunks, and an index of them.
struct ZarrShards {
  std::vector<std::uint64_t> chunks;  ///< in a shard, along each axis
  bool indexAtEnd = true;
  bool indexChecked = true;  ///< by a checksum behind it

  std::uint64_t indexBytes() const;
};

/// What the metadata of an array say: Zarr version 2 (zarr.dev, .zarray) or 3 (zarr.json).
struct ZarrArray {
  std::string path;  ///< in the store; "" for all of it
  std::vector<std::uint64_t> shape;
  std::vector<std::uint64_t> chunk;        ///< samples of a chunk along each axis
  std::vector<std::uint64_t> chunkStride;  ///< in samples, along each axis of an unpacked chunk
  SampleType type = SampleType::Float32;
  bool half = false;  ///< stored as floats of 16 bits
  std::endian order = std::endian::little;
  std::array<std::byte, 8> fill{};  ///< a sample of `type` in the order of this machine
  std::vector<ZarrCodec> codecs;    ///< as they were applied
  std::optional<ZarrShards> shards;
  bool keysWithC = false;  ///< "c/0/1", not "0/1"
  char separator = '.';
  std::vector<std::string> names;  ///< of the axes; "" or none if they are not said

  std::size_t storedSize() const { return half ? 2 : sizeOf(type); }
  std::uint64_t chunkSamples() const;
  std::uint64_t chunkBytes() const { return chunkSamples() * storedSize(); }  ///< unpacked
  /// Of the file of a chunk or a shard, from its number along each axis.
  std::string key(const std::vector<std::uint64_t>& number) const;
};

/// What a group or an array says about itself.
struct ZarrNode {
  std::string where;  ///< its file
  std::optional<ZarrArray> array;
  nlohmann::json attributes;  ///< an object
};

/// Reads the metadata of the group or array at a path in the store; nothing if there are none.
/// Fails for what is damaged and, for arrays, for what cannot be read: named.
Result<std::optional<ZarrNode>> readZarrNode(const ZarrStore& store, const std::string& path);

/// The member of an object; null if it is none, or has none of the name.
const nlohmann::json& memberOf(const nlohmann::json& object, const char* name);

/// Metadata for a message: short, and without controls.
std::string shownJson(const nlohmann::json& value);

}  // namespace t4d::voxel4d
