#include "formats/t4d/chunk_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace t4d::formats {

using model::Attribute;
using model::Domain;
using model::Point4;
using model::ScalarType;
using t4d_layout::ByteReader;
using t4d_layout::ByteWriter;
using t4d_layout::Features;
using t4d_layout::PayloadReader;
using t4d_layout::PayloadWriter;

namespace {

/// `numberOf` makes a number of axis and coordinate.
template <class NumberOf>
void putPositionsAs(PayloadWriter& into, std::uint64_t count, const VertexMaker& vertices,
                    int level, NumberOf numberOf) {
  using Scalar = decltype(numberOf(0, 0.0));
  const auto make = [&](std::uint64_t first, std::span<std::byte> bytes) {
    std::vector<Point4> points(bytes.size() / (3 * sizeof(Scalar)));
    vertices(first, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::array<Scalar, 3> position;
      for (int axis = 0; axis < 3; ++axis) position[axis] = numberOf(axis, points[i][axis]);
      std::memcpy(bytes.data() + i * sizeof position, position.data(), sizeof position);
    }
  };
  putArray(into, MadeArray{model::scalarTypeOf<Scalar>(), 3, count, make}, level);
}

/// `coordinateOf` makes a coordinate of axis and number.
template <class Scalar, class CoordinateOf>
void setPositions(const std::vector<std::byte>& bytes, std::span<Point4> into,
                  CoordinateOf coordinateOf) {
  for (std::size_t i = 0; i < into.size(); ++i) {
    std::array<Scalar, 3> position;
    std::memcpy(position.data(), bytes.data() + i * sizeof position, sizeof position);
    for (int axis = 0; axis < 3; ++axis) into[i][axis] = coordinateOf(axis, position[axis]);
  }
}

Result<Attribute> takeAttribute(PayloadReader& from, const Features& features) {
  const auto domain = from.take<std::uint8_t>();
  const auto reserved = from.takeBytes(3);
  const auto nameBytes = from.take<std::uint32_t>();
  if (from.overrun()) return invalid("an attribute is truncated");
  if (domain != static_cast<std::uint8_t>(Domain::Vertex) &&
      domain != static_cast<std::uint8_t>(Domain::Cell)) {
    return invalid(fmt::format("an attribute has the unknown domain {}", domain));
  }
  const auto isZero = [](std::byte byte) { return byte == std::byte{0}; };
  if (!std::all_of(reserved.begin(), reserved.end(), isZero)) {
    return invalid("an attribute's reserved bytes are not zero");
  }
  if (nameBytes == 0 || nameBytes > t4d_layout::kMaxNameBytes) {
    return invalid(fmt::format("an attribute has a name of {} bytes; 1 to {} are allowed",
                               nameBytes, t4d_layout::kMaxNameBytes));
  }
  const auto name = from.takeBytes(nameBytes);
  if (from.overrun() || !from.skipPadding()) {
    return invalid("an attribute's name is truncated, or its padding is not zero");
  }
  auto array = takeArray(from, features);
  if (!array) return array.error();
  return Attribute{std::string(reinterpret_cast<const char*>(name.data()), name.size()),
                   static_cast<Domain>(domain), array->type, array->components,
                   std::move(array->bytes)};
}

}  // namespace

Error cutOff(const char* what) {
  return invalid(fmt::format("{} is shorter than its fixed part", what));
}

Result<void> checkEnd(const PayloadReader& from) {
  if (from.left() > 0) return invalid(fmt::format("{} bytes follow its last field", from.left()));
  if (from.blocksLeft() > 0) {
    return invalid(fmt::format("{} blocks belong to none of its arrays", from.blocksLeft()));
  }
  return {};
}

void putTime(ByteWriter& into, const model::TimeSpan& time) {
  into.put(time.begin);
  into.put(time.end);
}

model::TimeSpan takeTime(ByteReader& from) {
  model::TimeSpan time;
  time.begin = from.take<double>();
  time.end = from.take<double>();
  return time;
}

Result<void> checkTime(const model::TimeSpan& time) {
  if (std::isfinite(time.begin) && std::isfinite(time.end) && time.begin <= time.end) return {};
  return invalid(fmt::format("it lasts from time {} to {}", time.begin, time.end));
}

void putPositions(PayloadWriter& into, std::uint64_t count, const VertexMaker& vertices,
                  const ArrayOptions& options) {
  if (options.grid) {
    putPositionsAs(into, count, vertices, options.level,
                   [&](int axis, double x) { return *options.grid->number(axis, x); });
  } else if (options.float32) {
    putPositionsAs(into, count, vertices, options.level,
                   [](int, double x) { return static_cast<float>(x); });
  } else {
    putPositionsAs(into, count, vertices, options.level, [](int, double x) { return x; });
  }
}

void putTimes(PayloadWriter& into, std::uint64_t count, const VertexMaker& vertices, int level) {
  const auto make = [&](std::uint64_t first, std::span<std::byte> bytes) {
    std::vector<Point4> points(bytes.size() / sizeof(double));
    vertices(first, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::memcpy(bytes.data() + i * sizeof(double), &points[i][3], sizeof(double));
    }
  };
  putArray(into, MadeArray{ScalarType::Float64, 1, count, make}, level);
}

Result<PackedArray> takePositions(PayloadReader& from, const Features& features) {
  auto array = takePacked(from, features);
  if (!array) return array;
  const bool onGrid = array->type == ScalarType::Int32;
  const bool isFloat = array->type == ScalarType::Float32 || array->type == ScalarType::Float64;
  if (array->components != 3 || (!isFloat && !onGrid)) {
    return invalid("its positions are not rows of three numbers of type 6, 9 or 10");
  }
  if (onGrid && !features.grid) {
    return invalid("its positions are on a grid, a feature that the file does not name");
  }
  return array;
}

Result<void> unpackPositions(const PackedArray& array, std::size_t block, std::span<Point4> into,
                             const Features& features) {
  std::vector<std::byte> bytes(into.size() * array.rowBytes());
  if (auto unpacked = unpackBlock(array, block, bytes); !unpacked) return unpacked;
  const auto same = [](int, double x) { return x; };
  if (array.type == ScalarType::Int32) {
    setPositions<std::int32_t>(bytes, into, [&](int axis, std::int32_t number) {
      return features.grid->coordinate(axis, number);
    });
  } else if (array.type == ScalarType::Float32) {
    setPositions<float>(bytes, into, same);
  } else {
    setPositions<double>(bytes, into, same);
  }
  return {};
}

Result<void> unpackPositions(const PackedArray& array, std::span<Point4> into,
                             const Features& features) {
  for (std::size_t i = 0; i < array.blocks.size(); ++i) {
    const auto rest = into.subspan(i * t4d_layout::kBlockRows);
    const auto rows = rest.first(std::min<std::size_t>(rest.size(), t4d_layout::kBlockRows));
    if (auto unpacked = unpackPositions(array, i, rows, features); !unpacked) return unpacked;
  }
  return {};
}

void putAttribute(PayloadWriter& into, const Attribute& attribute, int level) {
  into.put(static_cast<std::uint8_t>(attribute.domain));
  into.putBytes("\0\0\0", 3);
  into.put(static_cast<std::uint32_t>(attribute.name.size()));
  into.putBytes(attribute.name.data(), attribute.name.size());
  into.pad();
  putArray(into,
           {attribute.type, static_cast<std::uint8_t>(attribute.components), attribute.values},
           level);
}

Result<std::vector<Attribute>> takeAttributes(PayloadReader& from, std::uint32_t count,
                                              const Features& features) {
  std::vector<Attribute> attributes;
  for (std::uint32_t i = 0; i < count; ++i) {
    auto attribute = takeAttribute(from, features);
    if (!attribute) return attribute.error();
    attributes.push_back(std::move(*attribute));
  }
  return attributes;
}

}  // namespace t4d::formats
