#include "t4d/voxel4d/volumes/zarr_array.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include <Eigen/Core>
#include <fmt/format.h>

#include "t4d/voxel4d/volumes/header_text.h"

namespace t4d::voxel4d {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMostMetadata = std::uint64_t{4} << 20U;
constexpr std::size_t kMostAxes = 8;
constexpr std::uint64_t kMostChunkBytes = std::uint64_t{1} << 30U;
constexpr std::uint64_t kMostChunksOfShard = std::uint64_t{1} << 20U;

std::string keyIn(const std::string& path, std::string_view name) {
  return path.empty() ? std::string(name) : path + "/" + std::string(name);
}

int deepestNesting(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

/// An object in a file of the store; nothing if there is no file.
Result<std::optional<json>> readObject(const ZarrStore& store, const std::string& key) {
  const auto text = store.read(key, kMostMetadata);
  if (!text) return text.error();
  if (!*text) return std::nullopt;
  constexpr int kDeepest = 100;
  if (deepestNesting(**text) > kDeepest) {
    return invalid(fmt::format("is nested deeper than {} levels", kDeepest), store.nameOf(key));
  }
  json value = json::parse(**text, nullptr, false);
  if (!value.is_object()) return invalid("is not a JSON object", store.nameOf(key));
  return value;
}

std::optional<std::vector<std::uint64_t>> sizesIn(const json& list) {
  if (!list.is_array() || list.empty() || list.size() > kMostAxes) return std::nullopt;
  std::vector<std::uint64_t> sizes;
  for (const json& size : list) {
    if (!size.is_number_unsigned() || size.get<std::uint64_t>() == 0) return std::nullopt;
    sizes.push_back(size.get<std::uint64_t>());
  }
  return sizes;
}

/// Of an array in C order, or with the axes in another order from the slowest to the fastest.
std::vector<std::uint64_t> stridesOf(const std::vector<std::uint64_t>& sizes,
                                     const std::vector<std::size_t>& order) {
  std::vector<std::uint64_t> strides(sizes.size());
  std::uint64_t stride = 1;
  for (std::size_t i = order.size(); i-- > 0;) {
    strides[order[i]] = stride;
    stride *= sizes[order[i]];
  }
  return strides;
}

std::vector<std::size_t> firstToLast(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// Reads one array; errors say what is wrong with which member of which file.
class ArrayReader {
 public:
  ArrayReader(const json& metadata, std::string where)
      : metadata_(metadata), where_(std::move(where)) {}

  Result<ZarrArray> readVersion2() {
    if (auto done = readShape(memberOf(metadata_, "chunks"), "chunks"); !done) return done.error();
    if (auto done = readTypeOfNumpy(); !done) return done.error();
    const json& order = memberOf(metadata_, "order");
    if (order != "C" && order != "F") return wrong("order", order);
    if (order == "F") std::ranges::reverse(order_);
    const json& filters = memberOf(metadata_, "filters");
    if (!filters.is_null() && !(filters.is_array() && filters.empty())) {
      return unsupported("the filter", memberOf(filters.is_array() ? filters[0] : filters, "id"),
                         "none");
    }
    if (const json& compressor = memberOf(metadata_, "compressor"); !compressor.is_null()) {
      if (auto done = addCodec(memberOf(compressor, "id")); !done) return done.error();
    }
    const json& separator = memberOf(metadata_, "dimension_separator");
    if (auto done = readSeparator(separator, '.'); !done) return done.error();
    if (auto done = readFill(); !done) return done.error();
    return finish();
  }

  Result<ZarrArray> readVersion3() {
    const json& grid = memberOf(metadata_, "chunk_grid");
    if (memberOf(grid, "name") != "regular") {
      return unsupported("the chunk grid", memberOf(grid, "name"), "regular");
    }
    if (auto done =
            readShape(memberOf(memberOf(grid, "configuration"), "chunk_shape"), "chunk_shape");
        !done) {
      return done.error();
    }
    if (auto done = readTypeByName(); !done) return done.error();
    const json& keys = memberOf(metadata_, "chunk_key_encoding");
    const json& name = keys.is_string() ? keys : memberOf(keys, "name");
    if (name != "default" && name != "v2") {
      return unsupported("the chunk key encoding", name, "default, v2");
    }
    array_.keysWithC = name == "default";
    if (auto done = readSeparator(memberOf(memberOf(keys, "configuration"), "separator"),
                                  array_.keysWithC ? '/' : '.');
        !done) {
      return done.error();
    }
    const json& transformers = memberOf(metadata_, "storage_transformers");
    if (transformers.is_array() && !transformers.empty()) {
      return unsupported("the storage transformer", memberOf(transformers[0], "name"), "none");
    }
    if (auto done = readCodecs(memberOf(metadata_, "codecs"), true); !done) return done.error();
    if (auto done = readFill(); !done) return done.error();
    if (const json& names = memberOf(metadata_, "dimension_names"); names.is_array()) {
      for (const json& axis : names) {
        array_.names.push_back(axis.is_string() ? axis.get<std::string>() : std::string());
      }
      if (array_.names.size() != array_.shape.size()) return wrong("dimension_names", names);
    }
    return finish();
  }

 private:
  Error wrong(std::string_view name, const json& value) const {
    return invalid(fmt::format("has the {} {}, which cannot be", name, shownJson(value)), where_);
  }

  Error unsupported(std::string_view what, const json& name, std::string_view known) const {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("uses {} {}, which cannot be read; known: {}", what, shownJson(name), known),
        where_);
  }

  Result<void> readShape(const json& chunks, const char* nameOfChunks) {
    const auto shape = sizesIn(memberOf(metadata_, "shape"));
    if (!shape) return wrong("shape", memberOf(metadata_, "shape"));
    const auto chunk = sizesIn(chunks);
    if (!chunk || chunk->size() != shape->size()) return wrong(nameOfChunks, chunks);
    array_.shape = *shape;
    array_.chunk = *chunk;
    order_ = firstToLast(shape->size());
    return {};
  }

  /// "<u2".
  Result<void> readTypeOfNumpy() {
    const json& value = memberOf(metadata_, "dtype");
    const std::string descr = value.is_string() ? value.get<std::string>() : std::string();
    std::string name;
    if (descr.size() == 3 && std::string_view("<>|").find(descr[0]) != std::string::npos &&
        descr[2] >= '1' && descr[2] <= '8') {
      const std::string bits = std::to_string(8 * (descr[2] - '0'));
      if (descr[1] == 'b') name = descr[2] == '1' ? "bool" : "";
      if (descr[1] == 'i') name = "int" + bits;
      if (descr[1] == 'u') name = "uint" + bits;
      if (descr[1] == 'f') name = "float" + bits;
      array_.order = descr[0] == '>' ? std::endian::big : std::endian::little;
    }
    return takeType(name, value);
  }

  Result<void> readTypeByName() {
    const json& value = memberOf(metadata_, "data_type");
    return takeType(value.is_string() ? value.get<std::string>() : std::string(), value);
  }

  Result<void> takeType(const std::string& name, const json& said) {
    array_.half = name == "float16";
    const auto type = array_.half ? SampleType::Float32 : sampleTypeNamed(name);
    if (!type) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("has samples of type {}; bools, integers of 8 to 64 bits and floats "
                              "of 16 to 64 bits can be read",
                              shownJson(said)),
                  where_);
    }
    array_.type = *type;
    return {};
  }

  Result<void> readSeparator(const json& value, char otherwise) {
    array_.separator = otherwise;
    if (value.is_null()) return {};
    if (value != "." && value != "/") return wrong("dimension separator", value);
    array_.separator = value.get<std::string>()[0];
    return {};
  }

  Result<void> addCodec(const json& name) {
    std::string plain = name.is_string() ? name.get<std::string>() : std::string();
    constexpr std::string_view kPrefix = "numcodecs.";
    if (plain.starts_with(kPrefix)) plain.erase(0, kPrefix.size());
    const auto codec = zarrCodecNamed(plain);
    if (!codec) return unsupported("the codec", name, zarrCodecNames());
    constexpr std::size_t kMostCodecs = 8;
    if (array_.codecs.size() == kMostCodecs) {
      return invalid(fmt::format("has more than {} codecs", kMostCodecs), where_);
    }
    array_.codecs.push_back(*codec);
    return {};
  }

  /// transpose, then bytes or sharding_indexed, then what packs bytes.
  Result<void> readCodecs(const json& codecs, bool mayShard) {
    if (!codecs.is_array()) return wrong("codecs", codecs);
    bool asBytes = false;
    for (const json& codec : codecs) {
      const json& name = codec.is_string() ? codec : memberOf(codec, "name");
      const json& configuration = memberOf(codec, "configuration");
      if (array_.shards && mayShard) {
        return unsupported("behind sharding_indexed the codec", name, "none");
      }
      Result<void> done;
      if (name == "transpose" && !asBytes) {
        done = transpose(memberOf(configuration, "order"));
      } else if (name == "bytes" && !asBytes) {
        done = readEndian(memberOf(configuration, "endian"));
        asBytes = true;
      } else if (name == "sharding_indexed" && !asBytes && mayShard) {
        if (order_ != firstToLast(order_.size())) {
          return unsupported("before sharding_indexed the codec", "transpose", "none");
        }
        done = shard(configuration);
        asBytes = true;
      } else if (asBytes) {
        done = addCodec(name);
      } else {
        return unsupported("the codec", name,
                           mayShard ? "transpose, bytes, sharding_indexed" : "transpose, bytes");
      }
      if (!done) return done;
    }
    return asBytes ? Result<void>() : Result<void>(wrong("codecs", codecs));
  }

  Result<void> transpose(const json& order) {
    if (order == "C") return {};
    if (order == "F") {
      std::ranges::reverse(order_);
      return {};
    }
    if (!order.is_array() || order.size() != order_.size()) return wrong("transpose", order);
    std::vector<std::size_t> moved;
    for (const json& axis : order) {
      if (!axis.is_number_unsigned() || axis.get<std::uint64_t>() >= order_.size()) {
        return wrong("transpose", order);
      }
      moved.push_back(order_[axis.get<std::size_t>()]);
    }
    std::vector<std::size_t> sorted = moved;
    std::ranges::sort(sorted);
    if (sorted != firstToLast(sorted.size())) return wrong("transpose", order);
    order_ = std::move(moved);
    return {};
  }

  Result<void> readEndian(const json& value) {
    if (!value.is_null() && value != "little" && value != "big") return wrong("endian", value);
    array_.order = value == "big" ? std::endian::big : std::endian::little;
    return {};
  }

  Result<void> shard(const json& configuration) {
    const json& shape = memberOf(configuration, "chunk_shape");
    const auto chunk = sizesIn(shape);
    if (!chunk || chunk->size() != array_.chunk.size()) return wrong("chunk_shape", shape);
    ZarrShards shards;
    std::uint64_t count = 1;
    for (std::size_t i = 0; i < chunk->size(); ++i) {
      if (array_.chunk[i] % (*chunk)[i] != 0) return wrong("chunk_shape", shape);
      shards.chunks.push_back(array_.chunk[i] / (*chunk)[i]);
      if (shards.chunks[i] > kMostChunksOfShard / count) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("has more than {} chunks in a shard", kMostChunksOfShard), where_);
      }
      count *= shards.chunks[i];
    }
    array_.chunk = *chunk;
    const json& location = memberOf(configuration, "index_location");
    if (!location.is_null() && location != "start" && location != "end") {
      return wrong("index_location", location);
    }
    shards.indexAtEnd = location != "start";
    const json& index = memberOf(configuration, "index_codecs");
    const auto nameAt = [&](std::size_t i) {
      return index[i].is_string() ? index[i] : memberOf(index[i], "name");
    };
    if (!index.is_array() || index.empty() || index.size() > 2 || nameAt(0) != "bytes" ||
        memberOf(memberOf(index[0], "configuration"), "endian") == "big" ||
        (index.size() == 2 && nameAt(1) != "crc32c")) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("has shards whose index has the codecs {}; known: bytes (little "
                              "endian), and crc32c behind it",
                              shownJson(index)),
                  where_);
    }
    shards.indexChecked = index.size() == 2;
    array_.shards = shards;
    return readCodecs(memberOf(configuration, "codecs"), false);
  }

  Result<void> readFill() {
    const json& value = memberOf(metadata_, "fill_value");
    if (value.is_null()) return {};
    const auto put = [&](auto number) {
      std::memcpy(array_.fill.data(), &number, sizeof number);
      return Result<void>();
    };
    const auto wrongFill = [&] { return Result<void>(wrong("fill_value", value)); };
    if (array_.type == SampleType::Bool) {
      if (value.is_boolean()) return put(static_cast<std::uint8_t>(value.get<bool>()));
      return value == 0 || value == 1 ? put(value.get<std::uint8_t>()) : wrongFill();
    }
    if (isInteger(array_.type)) return readWholeFill(value);
    const auto number = fillNumber(value);
    if (!number) return wrongFill();
    if (array_.type == SampleType::Float32) return put(static_cast<float>(*number));
    return put(*number);
  }

  Result<void> readWholeFill(const json& value) {
    const auto outside = [&] { return Result<void>(wrong("fill_value", value)); };
    const auto bits = static_cast<unsigned>(8 * sizeOf(array_.type));
    const bool isSigned = array_.type == SampleType::Int8 || array_.type == SampleType::Int16 ||
                          array_.type == SampleType::Int32 || array_.type == SampleType::Int64;
    std::uint64_t sample = 0;  // in two's complement
    if (value.is_number_float() && value.get<double>() == std::rint(value.get<double>()) &&
        std::abs(value.get<double>()) < 1e15) {
      sample = static_cast<std::uint64_t>(static_cast<std::int64_t>(value.get<double>()));
    } else if (value.is_number_integer()) {
      sample = value.is_number_unsigned() ? value.get<std::uint64_t>()
                                          : static_cast<std::uint64_t>(value.get<std::int64_t>());
    } else {
      return outside();
    }
    const bool negative = value.is_number_float()
                              ? value.get<double>() < 0
                              : !value.is_number_unsigned() && value.get<std::int64_t>() < 0;
    if (negative && !isSigned) return outside();
    const std::uint64_t magnitude = negative ? ~sample : sample;
    const unsigned room = isSigned ? bits - 1 : bits;
    if (room < 64 && magnitude >> room != 0) return outside();
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(array_.fill.data(), &sample, sizeOf(array_.type));
    return {};
  }

  /// A number, "NaN", "Infinity", or the bits in hexadecimals.
  std::optional<double> fillNumber(const json& value) const {
    if (value.is_number()) return value.get<double>();
    if (!value.is_string()) return std::nullopt;
    const std::string text = value.get<std::string>();
    if (text == "NaN") return std::numeric_limits<double>::quiet_NaN();
    if (text == "Infinity") return std::numeric_limits<double>::infinity();
    if (text == "-Infinity") return -std::numeric_limits<double>::infinity();
    if (!text.starts_with("0x") || text.size() != 2 + 2 * array_.storedSize()) return std::nullopt;
    std::uint64_t bits = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + 2, end, bits, 16);
    if (error != std::errc{} || stop != end) return std::nullopt;
    if (array_.half) {
      return static_cast<float>(
          Eigen::numext::bit_cast<Eigen::half>(static_cast<std::uint16_t>(bits)));
    }
    if (array_.type == SampleType::Float32) {
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    }
    return std::bit_cast<double>(bits);
  }

  Result<ZarrArray> finish() {
    std::uint64_t bytes = array_.storedSize();
    for (const std::uint64_t size : array_.chunk) {
      if (size > kMostChunkBytes / bytes) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("has chunks of more than {} bytes", kMostChunkBytes), where_);
      }
      bytes *= size;
    }
    array_.chunkStride = stridesOf(array_.chunk, order_);
    return std::move(array_);
  }

  const json& metadata_;
  std::string where_;
  ZarrArray array_;
  std::vector<std::size_t> order_;  // of the axes in a chunk, the slowest first
};

}  // namespace

std::string shownJson(const json& value) {
  return shown(value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 200));
}

const json& memberOf(const json& object, const char* name) {
  static const json kNone;
  if (!object.is_object()) return kNone;
  const auto found = object.find(name);
  return found == object.end() ? kNone : *found;
}

std::uint64_t ZarrShards::indexBytes() const {
  constexpr std::uint64_t kEntry = 16;
  return std::accumulate(chunks.begin(), chunks.end(), kEntry, std::multiplies<>()) +
         (indexChecked ? 4 : 0);
}

std::uint64_t ZarrArray::chunkSamples() const {
  return std::accumulate(chunk.begin(), chunk.end(), std::uint64_t{1}, std::multiplies<>());
}

std::string ZarrArray::key(const std::vector<std::uint64_t>& number) const {
  std::string text = keysWithC ? "c" : "";
  for (const std::uint64_t one : number) {
    if (!text.empty()) text += separator;
    text += std::to_string(one);
  }
  return keyIn(path, text);
}

Result<std::optional<ZarrNode>> readZarrNode(const ZarrStore& store, const std::string& path) {
  ZarrNode node;
  const auto take = [&](std::string_view name) -> Result<std::optional<json>> {
    auto object = readObject(store, keyIn(path, name));
    if (object && *object) node.where = store.nameOf(keyIn(path, name));
    return object;
  };
  const auto keep = [&](Result<ZarrArray> array) -> Result<std::optional<ZarrNode>> {
    if (!array) return array.error();
    node.array = std::move(*array);
    node.array->path = path;
    return node;
  };
  auto version3 = take("zarr.json");
  if (!version3) return version3.error();
  if (*version3) {
    if (memberOf(**version3, "zarr_format") != 3) {
      return invalid("is not of Zarr version 3", node.where);
    }
    node.attributes = memberOf(**version3, "attributes");
    if (memberOf(**version3, "node_type") != "array") return node;
    return keep(ArrayReader(**version3, node.where).readVersion3());
  }
  auto attributes = readObject(store, keyIn(path, ".zattrs"));
  if (!attributes) return attributes.error();
  if (*attributes) node.attributes = std::move(**attributes);
  const auto version2 = take(".zarray");
  if (!version2) return version2.error();
  if (*version2) {
    if (memberOf(**version2, "zarr_format") != 2) {
      return invalid("is not of Zarr version 2", node.where);
    }
    return keep(ArrayReader(**version2, node.where).readVersion2());
  }
  const auto group = take(".zgroup");
  if (!group) return group.error();
  if (!*group && !*attributes) return std::nullopt;
  if (*attributes) node.where = store.nameOf(keyIn(path, ".zattrs"));
  return node;
}

}  // namespace t4d::voxel4d
