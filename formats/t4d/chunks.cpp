#include "formats/t4d/chunks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "formats/t4d/chunk_fields.h"
#include "formats/t4d/names.h"

namespace t4d::formats {
namespace {

using model::Attribute;
using model::Connectivity;
using model::Domain;
using model::Point4;
using model::ScalarType;
using t4d_layout::ByteReader;
using t4d_layout::ByteWriter;
using t4d_layout::Features;
using t4d_layout::PayloadReader;
using t4d_layout::PayloadView;
using t4d_layout::PayloadWriter;

constexpr std::uint32_t kZero = 0;

VertexMaker makerOf(std::span<const Point4> vertices) {
  return [=](std::uint64_t first, std::span<Point4> into) {
    std::copy_n(vertices.begin() + static_cast<std::ptrdiff_t>(first), into.size(), into.begin());
  };
}

template <class Scalar>
std::vector<Scalar> numbersOf(const Array& array) {
  std::vector<Scalar> numbers(array.bytes.size() / sizeof(Scalar));
  if (!numbers.empty()) std::memcpy(numbers.data(), array.bytes.data(), array.bytes.size());
  return numbers;
}

void putParts(ByteWriter& into, const SlabParts& parts) {
  into.put(parts.connectivity);
  into.put(parts.lower);
  into.put(parts.upper);
  into.put(parts.body);
}

SlabParts takeParts(ByteReader& from) {
  SlabParts parts;
  parts.connectivity = from.take<std::uint64_t>();
  parts.lower = from.take<std::uint64_t>();
  parts.upper = from.take<std::uint64_t>();
  parts.body = from.take<std::uint32_t>();
  return parts;
}

/// Checks the attributes of vertices among those of a part of a slab with `count` vertices.
Result<void> checkVertexRows(std::span<const Attribute> attributes, std::uint64_t count) {
  for (const Attribute& attribute : attributes) {
    if (attribute.domain != Domain::Vertex) continue;
    if (attribute.rows() != count) {
      return invalid(fmt::format("its attribute '{}' has {} rows for {} vertices", attribute.name,
                                 attribute.rows(), count));
    }
    if (count == 0) {
      return invalid(
          fmt::format("it has an attribute '{}' of vertices, of which it stores none of its own",
                      attribute.name));
    }
  }
  return {};
}

/// Extends the ranges of a block by a vertex.
void extend(BlockRanges& ranges, std::uint32_t vertex, const model::VertexCounts& counts) {
  const std::size_t part = vertex < counts.lowerCount ? 0 : vertex < counts.firstUpper() ? 2 : 4;
  if (ranges[part] == ranges[part + 1]) ranges[part] = vertex;
  ranges[part] = std::min(ranges[part], vertex);
  ranges[part + 1] = std::max(ranges[part + 1], vertex + 1);
}

/// Calls visit(first, last) for each block of cells, if there are several.
template <class Visit>
void forEachCellBlock(const Connectivity& connectivity, Visit visit) {
  const std::size_t count = connectivity.cells.size();
  if (count <= t4d_layout::kBlockRows) return;
  for (std::size_t at = 0; at < count; at += t4d_layout::kBlockRows) {
    visit(at, std::min<std::size_t>(count, at + t4d_layout::kBlockRows));
  }
}

}  // namespace

BlockRanges rangesOf(std::span<const model::Cell> cells, const model::VertexCounts& counts) {
  const std::span<const std::uint32_t> corners(cells.empty() ? nullptr : cells.front().data(),
                                               4 * cells.size());
  // Compilers vectorise signed numbers and masks.
  const auto ordered = [](std::uint32_t vertex) {
    return static_cast<std::int32_t>(vertex ^ 0x80000000U);
  };
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  const std::int32_t interior = ordered(counts.lowerCount);
  const std::int32_t upper = ordered(counts.firstUpper());
  // The first vertex of all, the first not below the interior, and the first of the upper layer; of
  // those before the interior, before the upper layer, and of all, the last.
  std::array<std::int32_t, 3> first = {kMost, kMost, kMost};
  std::array<std::int32_t, 3> last = {kLeast, kLeast, kLeast};
  for (const std::uint32_t vertex : corners) {
    const std::int32_t place = ordered(vertex);
    const std::int32_t isLower = -static_cast<std::int32_t>(place < interior);
    const std::int32_t isBefore = -static_cast<std::int32_t>(place < upper);
    first[0] = std::min(first[0], place);
    first[1] = std::min(first[1], (place & ~isLower) | (kMost & isLower));
    first[2] = std::min(first[2], (place & ~isBefore) | (kMost & isBefore));
    last[0] = std::max(last[0], (place & isLower) | (kLeast & ~isLower));
    last[1] = std::max(last[1], (place & isBefore) | (kLeast & ~isBefore));
    last[2] = std::max(last[2], place);
  }
  BlockRanges ranges{};
  const std::array<std::int32_t, 3> ends = {interior, upper, kMost};
  for (std::size_t part = 0; part < 3; ++part) {
    if (first[part] >= ends[part]) continue;
    ranges[2 * part] = static_cast<std::uint32_t>(first[part]) ^ 0x80000000U;
    ranges[2 * part + 1] = (static_cast<std::uint32_t>(last[part]) ^ 0x80000000U) + 1;
  }
  return ranges;
}

std::vector<BlockRanges> rangesOfBlocks(const Connectivity& connectivity) {
  std::vector<BlockRanges> all;
  const std::uint32_t firstMean = connectivity.firstMean();
  const std::uint32_t firstUpper = connectivity.firstUpper();
  const model::Means& means = connectivity.means;
  forEachCellBlock(connectivity, [&](std::size_t begin, std::size_t end) {
    if (means.size() == 0) {
      const std::span cells(connectivity.cells);
      all.push_back(rangesOf(cells.subspan(begin, end - begin), connectivity));
      return;
    }
    BlockRanges ranges{};
    const auto add = [&](std::uint32_t vertex) { extend(ranges, vertex, connectivity); };
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::uint32_t vertex : connectivity.cells[i]) {
        if (vertex < firstMean || vertex >= firstUpper) {
          add(vertex);
          continue;
        }
        const std::uint32_t mean = vertex - firstMean;
        for (std::uint32_t k = means.offsets[mean]; k < means.offsets[mean + 1]; ++k) {
          add(means.sources[k]);
        }
      }
    }
    all.push_back(ranges);
  });
  return all;
}

Point4 roundedPoint(const Point4& vertex, const ArrayOptions& options) {
  const model::Point3 position = vertex.head<3>();
  Point4 rounded = vertex;
  if (options.grid) {
    rounded.head<3>() = options.grid->nearest(position);
  } else if (options.float32) {
    rounded.head<3>() = position.cast<float>().cast<double>();
  }
  return rounded;
}

model::Slab roundedSlab(const model::Slab& slab, const ArrayOptions& options) {
  model::Slab rounded = slab;
  for (Point4& vertex : rounded.vertices) vertex = roundedPoint(vertex, options);
  setMeans(*rounded.connectivity, rounded.vertices);
  return rounded;
}

std::vector<model::Bounds4> boundsOfBlocks(const Connectivity& connectivity,
                                           std::span<const Point4> vertices) {
  std::vector<model::Bounds4> all;
  forEachCellBlock(connectivity, [&](std::size_t begin, std::size_t end) {
    model::Bounds4 bounds;
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::uint32_t vertex : connectivity.cells[i]) bounds.add(vertices[vertex]);
    }
    all.push_back(bounds);
  });
  return all;
}

namespace {

/// The fields of a CONN up to its arrays.
void putCounts(PayloadWriter& into, const model::VertexCounts& slab, std::uint32_t means,
               std::size_t attributes, const std::vector<BlockRanges>& ranges) {
  into.put(slab.vertexCount);
  into.put(slab.lowerCount);
  into.put(slab.upperCount);
  into.put(means);
  into.put(static_cast<std::uint32_t>(attributes));
  into.put(static_cast<std::uint32_t>(ranges.size()));
  into.putBytes(ranges.data(), ranges.size() * sizeof(BlockRanges));
}

/// A block of cells of a slab that is made piece by piece, checked.
struct MadeBlock {
  BlockRanges ranges{};
  model::Bounds4 bounds;
  std::optional<Error> error;

  void make(const model::StreamedSlab& slab, std::uint64_t first, std::span<model::Cell> cells) {
    slab.cells(first, cells);
    auto checked = model::checkCells(cells, slab.vertexCount, first);
    if (!checked) {
      error = checked.error();
      return;
    }
    ranges = rangesOf(cells, slab);
    if (slab.cellCount > t4d_layout::kBlockRows) addBounds(slab, cells);
  }

 private:
  void addBounds(const model::StreamedSlab& slab, std::span<const model::Cell> cells) {
    // Cells share most vertices: each is added once. The marks of the three ranges follow one
    // another.
    std::array<std::uint32_t, 3> shifts{};  // from the number of a vertex to its mark
    std::uint32_t count = 0;
    for (std::size_t part = 0; part < 3; ++part) {
      shifts[part] = count - ranges[2 * part];
      count += ranges[2 * part + 1] - ranges[2 * part];
    }
    thread_local std::vector<std::uint8_t> used;
    used.assign(count, 0);
    const std::uint32_t firstUpper = slab.firstUpper();
    for (const model::Cell& cell : cells) {
      for (const std::uint32_t vertex : cell) {
        const std::uint32_t shift = vertex < slab.lowerCount ? shifts[0]
                                    : vertex < firstUpper    ? shifts[1]
                                                             : shifts[2];
        used[vertex + shift] = 1;
      }
    }
    thread_local std::vector<Point4> vertices;
    for (std::size_t part = 0; part < 3; ++part) {
      const std::uint32_t begin = ranges[2 * part];
      vertices.resize(ranges[2 * part + 1] - begin);
      slab.vertices(begin, vertices);
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (used[begin + shifts[part] + i] != 0) bounds.add(vertices[i]);
      }
    }
  }
};

}  // namespace

Result<StreamedConnectivity> encodeConnectivity(const model::StreamedSlab& slab, int level) {
  std::vector<MadeBlock> blocks(t4d_layout::blockCount(slab.cellCount));
  PayloadWriter cells;
  const auto make = [&](std::uint64_t first, std::span<std::byte> bytes) {
    static_assert(alignof(model::Cell) <= alignof(std::max_align_t));
    const std::span<model::Cell> into(reinterpret_cast<model::Cell*>(bytes.data()),
                                      bytes.size() / sizeof(model::Cell));
    MadeBlock& block = blocks[first / t4d_layout::kBlockRows];
    block = {};
    block.make(slab, first, into);
  };
  putArray(cells, MadeArray{ScalarType::UInt32, 4, slab.cellCount, make, /*isMany=*/true}, level);
  StreamedConnectivity made;
  std::vector<BlockRanges> ranges;
  for (const MadeBlock& block : blocks) {
    if (block.error) return *block.error;
    if (blocks.size() == 1) break;
    ranges.push_back(block.ranges);
    made.bounds.push_back(block.bounds);
  }
  putCounts(made.payload, slab, 0, 0, ranges);
  made.payload.append(std::move(cells));
  return made;
}

PayloadWriter encodeConnectivity(const Connectivity& connectivity, const ArrayOptions& options) {
  const int level = options.level;
  PayloadWriter payload;
  putCounts(payload, connectivity, connectivity.means.size(), connectivity.cellAttributes.size(),
            rangesOfBlocks(connectivity));
  // Swept solids, which have means, store few connectivities.
  const bool isMany = connectivity.means.size() == 0;
  putArray(payload, {ScalarType::UInt32, 4, std::as_bytes(std::span(connectivity.cells)), isMany},
           level);
  if (connectivity.means.size() > 0) {
    std::vector<std::uint32_t> sizes;
    for (std::uint32_t i = 0; i < connectivity.means.size(); ++i) {
      sizes.push_back(connectivity.means.offsets[i + 1] - connectivity.means.offsets[i]);
    }
    putArray(payload, viewOf(sizes), level);
    putArray(payload, viewOf(connectivity.means.sources), level);
  }
  for (const Attribute& attribute : connectivity.cellAttributes) {
    putAttribute(payload, attribute, level);
  }
  return payload;
}

Result<ConnectivityFront> takeConnectivityFront(PayloadReader& from, const Features& features) {
  ConnectivityFront front;
  front.counts.vertexCount = from.take<std::uint32_t>();
  front.counts.lowerCount = from.take<std::uint32_t>();
  front.counts.upperCount = from.take<std::uint32_t>();
  front.means = from.take<std::uint32_t>();
  front.attributes = from.take<std::uint32_t>();
  const auto rangeCount = from.take<std::uint32_t>();
  const auto ranges = from.takeBytes(rangeCount * sizeof(BlockRanges));
  if (from.overrun()) return cutOff("a connectivity");
  front.ranges.resize(rangeCount);
  if (rangeCount > 0) std::memcpy(front.ranges.data(), ranges.data(), ranges.size());
  auto cells = takePacked(from, features);
  if (!cells) return cells.error();
  if (auto fits = checkArray(*cells, ScalarType::UInt32, 4); !fits) return fits.error();
  front.cells = *cells;
  return front;
}

Result<std::shared_ptr<const Connectivity>> decodeConnectivity(const PayloadView& payload,
                                                               const Features& features) {
  PayloadReader from(payload);
  const auto front = takeConnectivityFront(from, features);
  if (!front) return front.error();
  auto connectivity = std::make_shared<Connectivity>();
  static_cast<model::VertexCounts&>(*connectivity) = front->counts;
  const std::uint32_t meanCount = front->means;
  connectivity->cells.resize(front->cells.rows);
  if (auto set = unpack(front->cells, std::as_writable_bytes(std::span(connectivity->cells)));
      !set) {
    return set.error();
  }
  if (meanCount > 0) {
    if (!features.means) return invalid("it has means, a feature that the file does not name");
    auto sizes = takeArrayOf(from, ScalarType::UInt32, 1, features);
    if (!sizes) return sizes.error();
    auto sources = takeArrayOf(from, ScalarType::UInt32, 1, features);
    if (!sources) return sources.error();
    if (sizes->rows != meanCount) {
      return invalid(fmt::format("it has {} means but the sizes of {}", meanCount, sizes->rows));
    }
    connectivity->means.sources = numbersOf<std::uint32_t>(*sources);
    std::uint64_t end = 0;
    connectivity->means.offsets.reserve(meanCount + std::size_t{1});
    connectivity->means.offsets.push_back(0);
    for (const std::uint32_t size : numbersOf<std::uint32_t>(*sizes)) {
      end += size;
      if (end > connectivity->means.sources.size()) {
        return invalid("its means have more sources than are listed");
      }
      connectivity->means.offsets.push_back(static_cast<std::uint32_t>(end));
    }
    if (end != connectivity->means.sources.size()) {
      return invalid(fmt::format("its means have {} sources, of which {} are listed", end,
                                 connectivity->means.sources.size()));
    }
  }
  auto attributes = takeAttributes(from, front->attributes, features);
  if (!attributes) return attributes.error();
  connectivity->cellAttributes = std::move(*attributes);
  if (auto end = checkEnd(from); !end) return end.error();
  if (auto sound = checkConnectivity(*connectivity); !sound) return sound.error();
  if (auto sound = checkStorable(connectivity->cellAttributes, {}); !sound) {
    return sound.error();
  }
  if (rangesOfBlocks(*connectivity) != front->ranges) {
    return invalid("the ranges of vertices of its blocks are not those of their cells");
  }
  return connectivity;
}

namespace {

PayloadWriter encodeLayer(double time, std::uint64_t count, const VertexMaker& vertices,
                          std::span<const Attribute> attributes, const ArrayOptions& options) {
  PayloadWriter payload;
  payload.put(time);
  payload.put(static_cast<std::uint32_t>(attributes.size()));
  payload.put(kZero);
  putPositions(payload, count, vertices, options);
  for (const Attribute& attribute : attributes) putAttribute(payload, attribute, options.level);
  return payload;
}

}  // namespace

PayloadWriter encodeLayer(double time, std::span<const Point4> vertices,
                          std::span<const Attribute> attributes, const ArrayOptions& options) {
  return encodeLayer(time, vertices.size(), makerOf(vertices), attributes, options);
}

PayloadWriter encodeLayer(double time, std::uint64_t count, const VertexMaker& vertices,
                          const ArrayOptions& options) {
  return encodeLayer(time, count, vertices, {}, options);
}

Result<LayerFront> takeLayerFront(PayloadReader& from, const Features& features) {
  LayerFront front;
  front.time = from.take<double>();
  front.attributes = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  if (from.overrun()) return cutOff("a layer");
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  if (!std::isfinite(front.time)) return invalid(fmt::format("it is at time {}", front.time));
  const auto positions = takePositions(from, features);
  if (!positions) return positions.error();
  if (positions->rows == 0) return invalid("it has no vertices");
  front.positions = *positions;
  return front;
}

Result<Layer> decodeLayer(const PayloadView& payload, const Features& features) {
  PayloadReader from(payload);
  const auto front = takeLayerFront(from, features);
  if (!front) return front.error();
  Layer layer;
  layer.time = front->time;
  layer.positions = front->positions;
  auto attributes = takeAttributes(from, front->attributes, features);
  if (!attributes) return attributes.error();
  layer.attributes = std::move(*attributes);
  for (const Attribute& attribute : layer.attributes) {
    if (attribute.domain != Domain::Vertex) {
      return invalid(fmt::format("its attribute '{}' is not one of vertices", attribute.name));
    }
  }
  if (auto sound = checkVertexRows(layer.attributes, layer.size()); !sound) {
    return sound.error();
  }
  if (auto end = checkEnd(from); !end) return end.error();
  if (auto sound = checkStorable({}, layer.attributes); !sound) return sound.error();
  return layer;
}

Result<void> unpackLayer(const Layer& layer, std::span<Point4> into, const Features& features) {
  if (auto unpacked = unpackPositions(layer.positions, into, features); !unpacked) return unpacked;
  for (Point4& vertex : into) vertex[3] = layer.time;
  return {};
}

PayloadWriter encodePose(const PosedLayer& posed) {
  PayloadWriter payload;
  payload.put(posed.time);
  payload.put(posed.layer);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) payload.put(posed.pose(row, column));
  }
  return payload;
}

Result<PosedLayer> decodePose(const PayloadView& payload, const Features& features) {
  PayloadReader from(payload);
  PosedLayer posed;
  posed.time = from.take<double>();
  posed.layer = from.take<std::uint64_t>();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) posed.pose(row, column) = from.take<double>();
  }
  if (from.overrun()) return cutOff("a pose");
  if (auto end = checkEnd(from); !end) return end.error();
  if (!features.pose) return invalid("it is a pose, a feature that the file does not name");
  if (!std::isfinite(posed.time)) return invalid(fmt::format("it is at time {}", posed.time));
  if (!posed.pose.allFinite()) return invalid("its matrix has numbers that are not finite");
  return posed;
}

std::vector<Attribute> ownAttributes(const model::Slab& slab) {
  const Connectivity& connectivity = *slab.connectivity;
  const std::uint32_t interior = connectivity.firstMean() - connectivity.lowerCount;
  std::vector<Attribute> own;
  if (interior > 0) own = vertexRows(slab.attributes, connectivity.lowerCount, interior);
  std::ranges::copy_if(slab.attributes, std::back_inserter(own),
                       [](const Attribute& attribute) { return attribute.domain == Domain::Cell; });
  return own;
}

namespace {

/// The fields of a SLAB from the number of its bounds on, up to its attributes.
PayloadWriter boundsAndInterior(std::span<const model::Bounds4> bounds, std::uint64_t interior,
                                const VertexMaker& vertices, const ArrayOptions& options) {
  PayloadWriter payload;
  payload.put(static_cast<std::uint32_t>(bounds.size()));
  payload.put(kZero);
  for (const model::Bounds4& block : bounds) {
    for (const Point4* corner : {&block.min, &block.max}) {
      for (int k = 0; k < 4; ++k) payload.put((*corner)[k]);
    }
  }
  putPositions(payload, interior, vertices, options);
  putTimes(payload, interior, vertices, options.level);
  return payload;
}

}  // namespace

PayloadWriter encodeSlab(const model::TimeSpan& time, const SlabParts& parts,
                         SlabContents contents) {
  PayloadWriter payload;
  putTime(payload, time);
  putParts(payload, parts);
  payload.put(contents.attributes);
  payload.append(std::move(contents.payload));
  return payload;
}

SlabContents encodeContents(const model::StreamedSlab& slab, std::span<const model::Bounds4> bounds,
                            const ArrayOptions& options) {
  const auto interior = [&](std::uint64_t first, std::span<Point4> into) {
    slab.vertices(slab.lowerCount + static_cast<std::uint32_t>(first), into);
  };
  return {0, boundsAndInterior(bounds, slab.firstUpper() - slab.lowerCount, interior, options)};
}

SlabContents encodeContents(const model::Slab& slab, const ArrayOptions& options) {
  const Connectivity& connectivity = *slab.connectivity;
  const auto interior =
      std::span(slab.vertices)
          .subspan(connectivity.lowerCount, connectivity.firstMean() - connectivity.lowerCount);
  const std::vector<Attribute> attributes = ownAttributes(slab);
  // Slabs with means are those of swept solids, which are small and read whole.
  std::vector<model::Bounds4> bounds;
  if (connectivity.means.size() == 0) bounds = boundsOfBlocks(connectivity, slab.vertices);
  SlabContents contents = {static_cast<std::uint32_t>(attributes.size()),
                           boundsAndInterior(bounds, interior.size(), makerOf(interior), options)};
  for (const Attribute& attribute : attributes) {
    putAttribute(contents.payload, attribute, options.level);
  }
  return contents;
}

PayloadWriter encodeSlab(const model::Slab& slab, const SlabParts& parts,
                         const ArrayOptions& options) {
  return encodeSlab({slab.timeBegin, slab.timeEnd}, parts, encodeContents(slab, options));
}

Result<SlabFront> takeSlabFront(PayloadReader& from, const Features& features) {
  SlabFront front;
  front.time = takeTime(from);
  front.parts = takeParts(from);
  front.attributes = from.take<std::uint32_t>();
  const auto boundsCount = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  constexpr std::size_t kBoundsBytes = 8 * sizeof(double);
  if (from.overrun() || boundsCount > from.left() / kBoundsBytes) return cutOff("a slab");
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  if (auto checked = checkTime(front.time); !checked) return checked.error();
  front.cellBounds.resize(boundsCount);
  for (model::Bounds4& block : front.cellBounds) {
    for (Point4* corner : {&block.min, &block.max}) {
      for (int k = 0; k < 4; ++k) (*corner)[k] = from.take<double>();
    }
  }
  const auto positions = takePositions(from, features);
  if (!positions) return positions.error();
  front.positions = *positions;
  const auto times = takePacked(from, features);
  if (!times) return times.error();
  if (auto fits = checkArray(*times, ScalarType::Float64, 1); !fits) return fits.error();
  if (times->rows != positions->rows) {
    return invalid(
        fmt::format("it has {} interior positions but {} times", positions->rows, times->rows));
  }
  front.times = *times;
  return front;
}

Result<SlabChunk> decodeSlab(const PayloadView& payload, const Features& features) {
  PayloadReader from(payload);
  auto front = takeSlabFront(from, features);
  if (!front) return front.error();
  SlabChunk slab;
  slab.time = front->time;
  slab.parts = front->parts;
  slab.cellBounds = std::move(front->cellBounds);
  const auto times = unpack(front->times);
  if (!times) return times.error();
  slab.interior.resize(front->positions.rows);
  if (auto set = unpackPositions(front->positions, slab.interior, features); !set) {
    return set.error();
  }
  for (std::size_t i = 0; i < slab.interior.size(); ++i) {
    std::memcpy(&slab.interior[i][3], times->data() + i * sizeof(double), sizeof(double));
  }
  auto attributes = takeAttributes(from, front->attributes, features);
  if (!attributes) return attributes.error();
  slab.attributes = std::move(*attributes);
  if (auto sound = checkVertexRows(slab.attributes, slab.interior.size()); !sound) {
    return sound.error();
  }
  if (auto end = checkEnd(from); !end) return end.error();
  return slab;
}

void addSlab(BodySummary& body, const model::TimeSpan& time, const model::VertexCounts& counts,
             std::uint64_t cells, const model::Bounds3& bounds) {
  if (body.slabs++ == 0) {
    body.time.begin = time.begin;
    body.vertices += counts.lowerCount;
  }
  body.time.end = time.end;
  body.vertices += counts.vertexCount - counts.lowerCount;
  body.tetrahedra += cells;
  body.bounds.add(bounds);
}

void addSlab(BodySummary& body, const model::Slab& slab) {
  model::Bounds3 bounds;
  for (const Point4& vertex : slab.vertices) bounds.add(vertex.head<3>());
  addSlab(body, {slab.timeBegin, slab.timeEnd}, *slab.connectivity, slab.connectivity->cells.size(),
          bounds);
}

Result<void> checkSummary(const BodySummary& said, const BodySummary& found) {
  if (said.vertices != found.vertices || said.tetrahedra != found.tetrahedra) {
    return invalid(fmt::format("the file says {} vertices and {} tetrahedra, it has {} and {}",
                               said.vertices, said.tetrahedra, found.vertices, found.tetrahedra));
  }
  if (said.bounds.min != found.bounds.min || said.bounds.max != found.bounds.max) {
    return invalid("the file states other bounds than it has");
  }
  return {};
}

PayloadWriter encodeDone(const Done& done) {
  PayloadWriter payload;
  payload.put(done.chunks);
  payload.put(static_cast<std::uint32_t>(done.bodies.size()));
  payload.put(kZero);
  for (const BodySummary& body : done.bodies) {
    payload.put(body.slabs);
    payload.put(body.vertices);
    payload.put(body.tetrahedra);
    putTime(payload, body.time);
    for (int k = 0; k < 3; ++k) payload.put(body.bounds.min[k]);
    for (int k = 0; k < 3; ++k) payload.put(body.bounds.max[k]);
  }
  return payload;
}

Result<Done> decodeDone(const PayloadView& payload) {
  PayloadReader from(payload);
  Done done;
  done.chunks = from.take<std::uint64_t>();
  const auto count = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  if (from.overrun()) return cutOff("the end mark");
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  if (from.left() != count * t4d_layout::kBodySummaryBytes) {
    return invalid(
        fmt::format("it has {} bytes for the summaries of {} bodies", from.left(), count));
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    BodySummary body;
    body.slabs = from.take<std::uint64_t>();
    body.vertices = from.take<std::uint64_t>();
    body.tetrahedra = from.take<std::uint64_t>();
    body.time = takeTime(from);
    for (int k = 0; k < 3; ++k) body.bounds.min[k] = from.take<double>();
    for (int k = 0; k < 3; ++k) body.bounds.max[k] = from.take<double>();
    if (auto checked = checkTime(body.time); !checked) return checked.error();
    if (body.bounds.min.hasNaN() || body.bounds.max.hasNaN()) {
      return invalid(fmt::format("the bounds of body {} are not numbers", i));
    }
    if (body.slabs == 0) return invalid(fmt::format("it says that body {} has no slab", i));
    done.bodies.push_back(body);
  }
  return done;
}

Result<void> checkStorable(std::span<const Attribute> ofConnectivity,
                           std::span<const Attribute> ofSlab) {
  std::set<std::pair<Domain, std::string_view>> seen;
  for (const auto attributes : {ofConnectivity, ofSlab}) {
    for (const Attribute& attribute : attributes) {
      const std::string& name = attribute.name;
      if (auto sound = checkName(name); !sound) {
        return invalid("an attribute's name " + sound.error().message);
      }
      if (attribute.components == 0 || attribute.components > 255) {
        return invalid(
            fmt::format("the attribute '{}' cannot be stored: a row has 1 to 255 numbers", name));
      }
      if (!seen.emplace(attribute.domain, name).second) {
        return invalid(fmt::format("there are two attributes '{}'", name));
      }
    }
  }
  return {};
}

}  // namespace t4d::formats
