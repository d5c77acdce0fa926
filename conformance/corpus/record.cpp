#include "conformance/corpus/record.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "conformance/corpus/zstd_frame.h"
#include "formats/t4d/chunks.h"
#include "platform/crc32c.h"

namespace t4d::conformance {

using model::ScalarType;

void Record::putBytes(const std::string& field, std::string_view bytes) {
  fields_[field] = {bytes_.size(), bytes.size()};
  bytes_.append(bytes);
}

void Record::pad(const std::string& field) {
  putBytes(field, std::string(formats::t4d_layout::padded(bytes_.size()) - bytes_.size(), '\0'));
}

void Record::putBlock(const std::string& name, std::string_view bytes) {
  blocks_.push_back({name, std::string(bytes)});
}

void Record::add(const std::string& prefix, const Record& record) {
  const std::size_t begin = bytes_.size();
  putBytes(prefix, record.bytes_);
  for (const auto& [field, place] : record.fields_) {
    fields_[prefix + "/" + field] = {begin + place.offset, place.size};
  }
  for (const auto& [name, bytes] : record.blocks_) blocks_.push_back({prefix + "/" + name, bytes});
}

bool Record::hasBlock(const std::string& name) const {
  return std::ranges::find(blocks_, name, &Block::name) != blocks_.end();
}

Record::Place Record::place(const std::string& field) const {
  const auto found = fields_.find(field);
  if (found == fields_.end()) throw std::out_of_range("no field " + field);
  return found->second;
}

std::string Record::contents(const std::string& name) const {
  const auto block = std::ranges::find(blocks_, name, &Block::name);
  if (block != blocks_.end()) return block->bytes;
  const Place at = place(name);
  return bytes_.substr(at.offset, at.size);
}

void Record::overwrite(const std::string& field, std::string_view bytes, std::size_t at) {
  const auto block = std::ranges::find(blocks_, field, &Block::name);
  if (block != blocks_.end()) {
    block->bytes.replace(at, bytes.size(), bytes);
  } else {
    bytes_.replace(place(field).offset + at, bytes.size(), bytes);
  }
}

Record Record::part(const std::string& prefix) const {
  const Place whole = place(prefix);
  Record part;
  part.bytes_ = bytes_.substr(whole.offset, whole.size);
  for (const auto& [field, place] : fields_) {
    if (!field.starts_with(prefix + "/")) continue;
    part.fields_[field.substr(prefix.size() + 1)] = {place.offset - whole.offset, place.size};
  }
  for (const auto& [name, bytes] : blocks_) {
    if (name.starts_with(prefix + "/")) {
      part.blocks_.push_back({name.substr(prefix.size() + 1), bytes});
    }
  }
  return part;
}

void Record::replace(const std::string& prefix, const Record& record) {
  const Place old = place(prefix);
  // Blocks are in the order of their arrays.
  const auto before = [&](const Block& block) {
    return place(block.name.substr(0, block.name.rfind('/'))).offset < old.offset;
  };
  const auto at = std::ranges::count_if(blocks_, before);
  std::erase_if(blocks_, [&](const Block& block) { return block.name.starts_with(prefix + "/"); });
  std::vector<Block> renamed;
  for (const auto& [name, bytes] : record.blocks_) renamed.push_back({prefix + "/" + name, bytes});
  blocks_.insert(blocks_.begin() + at, renamed.begin(), renamed.end());
  std::erase_if(fields_, [&](const auto& field) { return field.first.starts_with(prefix + "/"); });
  for (auto& [field, place] : fields_) {
    if (place.offset >= old.offset + old.size) place.offset += record.size() - old.size;
  }
  bytes_.replace(old.offset, old.size, record.bytes_);
  fields_[prefix] = {old.offset, record.size()};
  for (const auto& [field, place] : record.fields_) {
    fields_[prefix + "/" + field] = {old.offset + place.offset, place.size};
  }
}

std::size_t Record::frontSize() const {
  return blocks_.size() * formats::t4d_layout::kBlockEntryBytes + bytes_.size();
}

Record Record::asPayload() const {
  Record payload;
  for (const auto& [name, bytes] : blocks_) {
    payload.put(name + " size", static_cast<std::uint32_t>(bytes.size()));
    payload.put(name + " checksum", platform::crc32c(bytes.data(), bytes.size()));
  }
  const std::size_t begin = payload.size();
  payload.bytes_ += bytes_;
  for (const auto& [field, place] : fields_) {
    payload.fields_[field] = {begin + place.offset, place.size};
  }
  for (const auto& [name, bytes] : blocks_) {
    payload.putBytes(name, bytes);
    payload.pad(name + " padding");
  }
  return payload;
}

std::string transposed(std::string_view bytes, std::size_t rowBytes) {
  const std::size_t rows = bytes.size() / rowBytes;
  std::string result;
  for (std::size_t column = 0; column < rowBytes; ++column) {
    for (std::size_t row = 0; row < rows; ++row) result += bytes[row * rowBytes + column];
  }
  return result;
}

std::string repeats(std::string_view bytes, std::size_t components) {
  constexpr std::size_t kFarthest = 255;
  std::vector<std::uint32_t> numbers(bytes.size() / 4);
  bytes.copy(reinterpret_cast<char*>(numbers.data()), bytes.size());
  std::string distances;
  std::string others;
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::size_t distance = 1;
    while (distance <= std::min(i, kFarthest) && numbers[i - distance] != numbers[i]) ++distance;
    if (distance > std::min(i, kFarthest)) {
      distance = 0;
      const std::uint32_t step = numbers[i] - last;
      others += bytesOf(step >> 31U != 0 ? ~(step << 1U) : step << 1U);
      last = numbers[i];
    }
    distances += static_cast<char>(distance);
  }
  return transposed(distances, components) + (others.empty() ? "" : transposed(others, 4));
}

Record arrayRecord(std::uint8_t scalarType, std::uint8_t components, std::uint8_t codec,
                   std::uint64_t rows, const std::vector<std::string>& blocks) {
  Record record;
  record.put("scalar type", scalarType);
  record.put("components", components);
  record.put("codec", codec);
  record.putBytes("reserved", std::string(5, '\0'));
  record.put("rows", rows);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    record.putBlock(i == 0 ? "stored" : "stored " + std::to_string(i), blocks[i]);
  }
  return record;
}

Record arrayRecord(ScalarType type, std::uint8_t components, std::string_view bytes,
                   Storage storage) {
  const std::size_t rowBytes = model::scalarSize(type) * components;
  const std::uint64_t rows = bytes.size() / rowBytes;
  const bool repeat = storage == Storage::Repeats && type == ScalarType::UInt32;
  const std::uint8_t codec = storage == Storage::Raw || rows == 0 ? 0 : repeat ? 2 : 1;
  std::vector<std::string> blocks;
  while (!bytes.empty()) {
    const std::string_view block = bytes.substr(0, formats::t4d_layout::kBlockRows * rowBytes);
    bytes.remove_prefix(block.size());
    const std::string content = repeat ? repeats(block, components) : transposed(block, rowBytes);
    blocks.push_back(storage == Storage::Raw      ? std::string(block)
                     : storage == Storage::Blocks ? zstdFrame(content)
                                                  : zstdByLibrary(content));
  }
  return arrayRecord(static_cast<std::uint8_t>(type), components, codec, rows, blocks);
}

namespace {

template <class T, std::size_t kExtent>
std::string_view asText(std::span<T, kExtent> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

template <class T>
std::string_view asText(const std::vector<T>& numbers) {
  return asText(std::span<const T>(numbers));
}

Record positionsRecord(std::span<const model::Point4> vertices,
                       const formats::ArrayOptions& positions, Storage storage) {
  std::string bytes;
  for (const model::Point4& vertex : vertices) {
    for (int k = 0; k < 3; ++k) {
      bytes += positions.grid      ? bytesOf(*positions.grid->number(k, vertex[k]))
               : positions.float32 ? bytesOf(static_cast<float>(vertex[k]))
                                   : bytesOf(vertex[k]);
    }
  }
  const ScalarType type = positions.grid      ? ScalarType::Int32
                          : positions.float32 ? ScalarType::Float32
                                              : ScalarType::Float64;
  return arrayRecord(type, 3, bytes, storage);
}

void addAttributes(Record& into, std::span<const model::Attribute> attributes, Storage storage) {
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    into.add("attribute " + std::to_string(i), attributeRecord(attributes[i], storage));
  }
}

}  // namespace

Record attributeRecord(const model::Attribute& attribute, Storage storage) {
  Record record;
  record.put("domain", static_cast<std::uint8_t>(attribute.domain));
  record.putBytes("reserved", std::string(3, '\0'));
  record.put("name length", static_cast<std::uint32_t>(attribute.name.size()));
  record.putBytes("name", attribute.name);
  record.pad("name padding");
  record.add("values", arrayRecord(attribute.type, static_cast<std::uint8_t>(attribute.components),
                                   asText(attribute.values), storage));
  return record;
}

Record connectivityRecord(const model::Connectivity& connectivity, Storage storage) {
  const model::Means& means = connectivity.means;
  Record record;
  record.put("vertices", connectivity.vertexCount);
  record.put("lower", connectivity.lowerCount);
  record.put("upper", connectivity.upperCount);
  record.put("means", means.size());
  record.put("attributes", static_cast<std::uint32_t>(connectivity.cellAttributes.size()));
  const auto ranges = formats::rangesOfBlocks(connectivity);
  record.put("ranges", static_cast<std::uint32_t>(ranges.size()));
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    record.putBytes("range " + std::to_string(i), asText(std::span(ranges[i])));
  }
  record.add("cells", arrayRecord(ScalarType::UInt32, 4, asText(connectivity.cells), storage));
  if (means.size() > 0) {
    std::vector<std::uint32_t> sizes;
    for (std::uint32_t i = 0; i < means.size(); ++i) {
      sizes.push_back(means.offsets[i + 1] - means.offsets[i]);
    }
    record.add("mean sizes", arrayRecord(ScalarType::UInt32, 1, asText(sizes), storage));
    record.add("mean sources", arrayRecord(ScalarType::UInt32, 1, asText(means.sources), storage));
  }
  addAttributes(record, connectivity.cellAttributes, storage);
  return record;
}

Record layerRecord(double time, std::span<const model::Point4> vertices,
                   std::span<const model::Attribute> attributes,
                   const formats::ArrayOptions& positions, Storage storage) {
  Record record;
  record.put("time", time);
  record.put("attributes", static_cast<std::uint32_t>(attributes.size()));
  record.put("reserved", std::uint32_t{0});
  record.add("positions", positionsRecord(vertices, positions, storage));
  addAttributes(record, attributes, storage);
  return record;
}

Record poseRecord(double time, const model::Affine3x4& pose) {
  Record record;
  record.put("time", time);
  record.put("layer", std::uint64_t{0});
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      record.put("m" + std::to_string(row) + std::to_string(column), pose(row, column));
    }
  }
  return record;
}

Record slabRecord(const model::TimeSpan& time, std::uint32_t body,
                  const std::vector<model::Bounds4>& bounds,
                  std::span<const model::Point4> interior,
                  std::span<const model::Attribute> attributes,
                  const formats::ArrayOptions& positions, Storage storage) {
  Record record;
  record.put("begin", time.begin);
  record.put("end", time.end);
  record.put("connectivity", std::uint64_t{0});
  record.put("lower", std::uint64_t{0});
  record.put("upper", std::uint64_t{0});
  record.put("body", body);
  record.put("attributes", static_cast<std::uint32_t>(attributes.size()));
  record.put("bounds", static_cast<std::uint32_t>(bounds.size()));
  record.put("reserved", std::uint32_t{0});
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    record.putBytes("bounds " + std::to_string(i),
                    std::string(asText(std::span<const double>(bounds[i].min.data(), 4))) +
                        std::string(asText(std::span<const double>(bounds[i].max.data(), 4))));
  }
  record.add("interior positions", positionsRecord(interior, positions, storage));
  std::vector<double> times;
  for (const model::Point4& vertex : interior) times.push_back(vertex[3]);
  record.add("interior times", arrayRecord(ScalarType::Float64, 1, asText(times), storage));
  addAttributes(record, attributes, storage);
  return record;
}

}  // namespace t4d::conformance
