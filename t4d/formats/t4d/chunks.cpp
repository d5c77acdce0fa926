#include "t4d/formats/t4d/chunks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "t4d/formats/t4d/chunk_fields.h"
#include "t4d/formats/t4d/names.h"

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

std::vector<BlockRanges> rangesOfBlocks(const Connectivity& connectivity) {
  std::vector<BlockRanges> all;
  const std::uint32_t firstMean = connectivity.firstMean();
  const std::uint32_t firstUpper = connectivity.firstUpper();
  const model::Means& means = connectivity.means;
  forEachCellBlock(connectivity, [&](std::size_t begin, std::size_t end) {
    BlockRanges ranges{};
    const auto add = [&](std::uint32_t vertex) {
      const std::size_t part = vertex < connectivity.lowerCount ? 0 : vertex < firstUpper ? 2 : 4;
      if (ranges[part] == ranges[part + 1]) ranges[part] = vertex;
      ranges[part] = std::min(ranges[part], vertex);
      ranges[part + 1] = std::max(ranges[part + 1], vertex + 1);
    };
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

model::Slab roundedSlab(const model::Slab& slab) {
  model::Slab rounded = slab;
  for (Point4& vertex : rounded.vertices) {
    vertex.head<3>() = vertex.head<3>().cast<float>().cast<double>();
  }
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

PayloadWriter encodeConnectivity(const Connectivity& connectivity, const ArrayOptions& options) {
  const int level = options.level;
  PayloadWriter payload;
  payload.put(connectivity.vertexCount);
  payload.put(connectivity.lowerCount);
  payload.put(connectivity.upperCount);
  payload.put(connectivity.means.size());
  payload.put(static_cast<std::uint32_t>(connectivity.cellAttributes.size()));
  const std::vector<BlockRanges> ranges = rangesOfBlocks(connectivity);
  payload.put(static_cast<std::uint32_t>(ranges.size()));
  payload.putBytes(ranges.data(), ranges.size() * sizeof(BlockRanges));
  putArray(payload, {ScalarType::UInt32, 4, std::as_bytes(std::span(connectivity.cells))}, level);
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

Result<std::shared_ptr<const Connectivity>> decodeConnectivity(const PayloadView& payload,
                                                               Features features) {
  PayloadReader from(payload);
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->vertexCount = from.take<std::uint32_t>();
  connectivity->lowerCount = from.take<std::uint32_t>();
  connectivity->upperCount = from.take<std::uint32_t>();
  const auto meanCount = from.take<std::uint32_t>();
  const auto attributeCount = from.take<std::uint32_t>();
  const auto rangeCount = from.take<std::uint32_t>();
  const auto storedRanges = from.takeBytes(rangeCount * sizeof(BlockRanges));
  if (from.overrun()) return cutOff("a connectivity");

  auto cells = takeArrayOf(from, ScalarType::UInt32, 4, features);
  if (!cells) return pass(cells.error());
  connectivity->cells.resize(cells->rows);
  if (!cells->bytes.empty()) {
    std::memcpy(connectivity->cells.data(), cells->bytes.data(), cells->bytes.size());
  }
  if (meanCount > 0) {
    if (!features.means) return invalid("it has means, a feature that the file does not name");
    auto sizes = takeArrayOf(from, ScalarType::UInt32, 1, features);
    if (!sizes) return pass(sizes.error());
    auto sources = takeArrayOf(from, ScalarType::UInt32, 1, features);
    if (!sources) return pass(sources.error());
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
  auto attributes = takeAttributes(from, attributeCount, features);
  if (!attributes) return pass(attributes.error());
  connectivity->cellAttributes = std::move(*attributes);
  if (auto end = checkEnd(from); !end) return pass(end.error());
  if (auto sound = checkConnectivity(*connectivity); !sound) return pass(sound.error());
  if (auto sound = checkStorable(connectivity->cellAttributes, {}); !sound) {
    return pass(sound.error());
  }
  const std::vector<BlockRanges> ranges = rangesOfBlocks(*connectivity);
  if (!std::ranges::equal(storedRanges, std::as_bytes(std::span(ranges)))) {
    return invalid("the ranges of vertices of its blocks are not those of their cells");
  }
  return connectivity;
}

PayloadWriter encodeLayer(double time, std::span<const Point4> vertices,
                          std::span<const Attribute> attributes, const ArrayOptions& options) {
  PayloadWriter payload;
  payload.put(time);
  payload.put(static_cast<std::uint32_t>(attributes.size()));
  payload.put(kZero);
  putPositions(payload, vertices, options);
  for (const Attribute& attribute : attributes) putAttribute(payload, attribute, options.level);
  return payload;
}

Result<Layer> decodeLayer(const PayloadView& payload, Features features) {
  PayloadReader from(payload);
  Layer layer;
  layer.time = from.take<double>();
  const auto attributeCount = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  if (from.overrun()) return cutOff("a layer");
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  if (!std::isfinite(layer.time)) return invalid(fmt::format("it is at time {}", layer.time));
  const auto positions = takePositions(from, features);
  if (!positions) return pass(positions.error());
  if (positions->rows == 0) return invalid("it has no vertices");
  layer.positions = *positions;
  auto attributes = takeAttributes(from, attributeCount, features);
  if (!attributes) return pass(attributes.error());
  layer.attributes = std::move(*attributes);
  for (const Attribute& attribute : layer.attributes) {
    if (attribute.domain != Domain::Vertex) {
      return invalid(fmt::format("its attribute '{}' is not one of vertices", attribute.name));
    }
  }
  if (auto sound = checkVertexRows(layer.attributes, layer.size()); !sound) {
    return pass(sound.error());
  }
  if (auto end = checkEnd(from); !end) return pass(end.error());
  if (auto sound = checkStorable({}, layer.attributes); !sound) return pass(sound.error());
  return layer;
}

Result<void> unpackLayer(const Layer& layer, std::span<Point4> into) {
  if (auto unpacked = unpackPositions(layer.positions, into); !unpacked) return unpacked;
  for (Point4& vertex : into) vertex[3] = layer.time;
  return {};
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

PayloadWriter encodeSlab(const model::Slab& slab, const SlabParts& parts,
                         const ArrayOptions& options) {
  const Connectivity& connectivity = *slab.connectivity;
  const auto interior =
      std::span(slab.vertices)
          .subspan(connectivity.lowerCount, connectivity.firstMean() - connectivity.lowerCount);
  const std::vector<Attribute> attributes = ownAttributes(slab);
  PayloadWriter payload;
  putTime(payload, {slab.timeBegin, slab.timeEnd});
  putParts(payload, parts);
  payload.put(static_cast<std::uint32_t>(attributes.size()));
  const std::vector<model::Bounds4> bounds = boundsOfBlocks(connectivity, slab.vertices);
  payload.put(static_cast<std::uint32_t>(bounds.size()));
  payload.put(kZero);
  for (const model::Bounds4& block : bounds) {
    for (const Point4* corner : {&block.min, &block.max}) {
      for (int k = 0; k < 4; ++k) payload.put((*corner)[k]);
    }
  }
  putPositions(payload, interior, options);
  std::vector<double> times;
  times.reserve(interior.size());
  for (const Point4& vertex : interior) times.push_back(vertex[3]);
  putArray(payload, viewOf(times), options.level);
  for (const Attribute& attribute : attributes) putAttribute(payload, attribute, options.level);
  return payload;
}

Result<SlabChunk> decodeSlab(const PayloadView& payload, Features features) {
  PayloadReader from(payload);
  SlabChunk slab;
  slab.time = takeTime(from);
  slab.parts = takeParts(from);
  const auto attributeCount = from.take<std::uint32_t>();
  const auto boundsCount = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  constexpr std::size_t kBoundsBytes = 8 * sizeof(double);
  if (from.overrun() || boundsCount > from.left() / kBoundsBytes) return cutOff("a slab");
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  if (auto checked = checkTime(slab.time); !checked) return pass(checked.error());
  slab.cellBounds.resize(boundsCount);
  for (model::Bounds4& block : slab.cellBounds) {
    for (Point4* corner : {&block.min, &block.max}) {
      for (int k = 0; k < 4; ++k) (*corner)[k] = from.take<double>();
    }
  }
  const auto positions = takePositions(from, features);
  if (!positions) return pass(positions.error());
  auto times = takeArrayOf(from, ScalarType::Float64, 1, features);
  if (!times) return pass(times.error());
  if (times->rows != positions->rows) {
    return invalid(
        fmt::format("it has {} interior positions but {} times", positions->rows, times->rows));
  }
  slab.interior.resize(positions->rows);
  if (auto set = unpackPositions(*positions, slab.interior); !set) return pass(set.error());
  for (std::size_t i = 0; i < slab.interior.size(); ++i) {
    std::memcpy(&slab.interior[i][3], times->bytes.data() + i * sizeof(double), sizeof(double));
  }
  auto attributes = takeAttributes(from, attributeCount, features);
  if (!attributes) return pass(attributes.error());
  slab.attributes = std::move(*attributes);
  if (auto sound = checkVertexRows(slab.attributes, slab.interior.size()); !sound) {
    return pass(sound.error());
  }
  if (auto end = checkEnd(from); !end) return pass(end.error());
  return slab;
}

void addSlab(BodySummary& body, const model::Slab& slab) {
  const Connectivity& connectivity = *slab.connectivity;
  if (body.slabs++ == 0) {
    body.time.begin = slab.timeBegin;
    body.vertices += connectivity.lowerCount;
  }
  body.time.end = slab.timeEnd;
  body.vertices += connectivity.vertexCount - connectivity.lowerCount;
  body.tetrahedra += connectivity.cells.size();
  for (const Point4& vertex : slab.vertices) body.bounds.add(vertex.head<3>());
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
    if (auto checked = checkTime(body.time); !checked) return pass(checked.error());
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
