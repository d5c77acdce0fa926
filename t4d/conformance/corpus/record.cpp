#include "t4d/conformance/corpus/record.h"

#include <stdexcept>
#include <vector>

#include "t4d/conformance/corpus/zstd_frame.h"

namespace t4d::conformance {

using model::ScalarType;

void Record::putBytes(const std::string& field, std::string_view bytes) {
  fields_[field] = {bytes_.size(), bytes.size()};
  bytes_.append(bytes);
}

void Record::pad(const std::string& field) {
  putBytes(field, std::string(formats::t4d_layout::padded(bytes_.size()) - bytes_.size(), '\0'));
}

void Record::add(const std::string& prefix, const Record& record) {
  const std::size_t begin = bytes_.size();
  putBytes(prefix, record.bytes_);
  for (const auto& [field, place] : record.fields_) {
    fields_[prefix + "/" + field] = {begin + place.offset, place.size};
  }
}

Record::Place Record::place(const std::string& field) const {
  const auto found = fields_.find(field);
  if (found == fields_.end()) throw std::out_of_range("no field " + field);
  return found->second;
}

void Record::overwrite(const std::string& field, std::string_view bytes, std::size_t at) {
  bytes_.replace(place(field).offset + at, bytes.size(), bytes);
}

Record Record::part(const std::string& prefix) const {
  const Place whole = place(prefix);
  Record part;
  part.bytes_ = bytes_.substr(whole.offset, whole.size);
  for (const auto& [field, place] : fields_) {
    if (!field.starts_with(prefix + "/")) continue;
    part.fields_[field.substr(prefix.size() + 1)] = {place.offset - whole.offset, place.size};
  }
  return part;
}

void Record::replace(const std::string& prefix, const Record& record) {
  const Place old = place(prefix);
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

std::string transposed(std::string_view bytes, std::size_t rowBytes) {
  const std::size_t rows = bytes.size() / rowBytes;
  std::string result;
  for (std::size_t column = 0; column < rowBytes; ++column) {
    for (std::size_t row = 0; row < rows; ++row) result += bytes[row * rowBytes + column];
  }
  return result;
}

Record arrayRecord(std::uint8_t scalarType, std::uint8_t components, std::uint8_t codec,
                   std::uint64_t rows, std::string_view stored) {
  Record record;
  record.put("scalar type", scalarType);
  record.put("components", components);
  record.put("codec", codec);
  record.putBytes("reserved", std::string(5, '\0'));
  record.put("rows", rows);
  record.put("stored bytes", std::uint64_t{stored.size()});
  record.putBytes("stored", stored);
  record.pad();
  return record;
}

Record arrayRecord(ScalarType type, std::uint8_t components, std::string_view bytes,
                   Storage storage) {
  const std::size_t rowBytes = model::scalarSize(type) * components;
  const auto number = static_cast<std::uint8_t>(type);
  const std::uint64_t rows = bytes.size() / rowBytes;
  if (storage == Storage::Raw || rows == 0) {
    return arrayRecord(number, components, 0, rows, bytes);
  }
  const std::string content = transposed(bytes, rowBytes);
  return arrayRecord(number, components, 1, rows,
                     storage == Storage::Blocks ? zstdFrame(content) : zstdByLibrary(content));
}

namespace {

template <class T>
std::string_view asText(std::span<const T> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

template <class T>
std::string_view asText(const std::vector<T>& numbers) {
  return asText(std::span(numbers));
}

Record positionsRecord(std::span<const model::Point4> vertices, bool float32, Storage storage) {
  std::string bytes;
  for (const model::Point4& vertex : vertices) {
    for (int k = 0; k < 3; ++k) {
      bytes += float32 ? bytesOf(static_cast<float>(vertex[k])) : bytesOf(vertex[k]);
    }
  }
  return arrayRecord(float32 ? ScalarType::Float32 : ScalarType::Float64, 3, bytes, storage);
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
  record.put("reserved", std::uint32_t{0});
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

Record layerRecord(double time, std::span<const model::Point4> vertices, bool float32,
                   Storage storage) {
  Record record;
  record.put("time", time);
  record.add("positions", positionsRecord(vertices, float32, storage));
  return record;
}

Record slabRecord(const model::TimeSpan& time, std::uint32_t body,
                  std::span<const model::Point4> interior,
                  std::span<const model::Attribute> attributes, bool float32, Storage storage) {
  Record record;
  record.put("begin", time.begin);
  record.put("end", time.end);
  record.put("connectivity", std::uint64_t{0});
  record.put("lower", std::uint64_t{0});
  record.put("upper", std::uint64_t{0});
  record.put("body", body);
  record.put("attributes", static_cast<std::uint32_t>(attributes.size()));
  record.add("interior positions", positionsRecord(interior, float32, storage));
  std::vector<double> times;
  for (const model::Point4& vertex : interior) times.push_back(vertex[3]);
  record.add("interior times", arrayRecord(ScalarType::Float64, 1, asText(times), storage));
  addAttributes(record, attributes, storage);
  return record;
}

}  // namespace t4d::conformance
