#include "formats/t4d/file_slab.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace t4d::formats {

using namespace t4d_layout;
using model::Cell;
using model::CellBlock;
using model::Point4;

struct FileSlab::Cache {
  struct Entry {
    std::size_t part = 0;
    std::size_t block = 0;
    Vertices vertices;
  };
  /// Blocks of cells follow one another in space, so that they share most of what they need.
  static constexpr std::size_t kMost = 24;

  std::mutex mutex;
  std::list<Entry> entries;  // the last used first
};

FileSlab::FileSlab(const ChunkFile& file, const IndexRecord& record, const Features& features)
    : file_(&file), record_(record), features_(features) {}

FileSlab::~FileSlab() = default;

Result<std::shared_ptr<const FileSlab>> FileSlab::open(const ChunkFile& file,
                                                       const IndexRecord& record,
                                                       const Features& features) {
  std::shared_ptr<FileSlab> slab(new FileSlab(file, record, features));
  if (!record.extent || record.extent->cells <= kBlockRows) {
    return std::shared_ptr<const FileSlab>();
  }
  const auto plain = slab->openParts();
  if (!plain) return plain.error();
  if (!*plain) return std::shared_ptr<const FileSlab>();
  slab->cache_ = std::make_unique<Cache>();
  return slab;
}

/// Reads the fronts of all chunks; false if the slab is better read whole.
Result<bool> FileSlab::openParts() {
  const auto wrong = [&](std::uint64_t offset, const char* type, const Error& error) {
    return file_->damaged(offset, fmt::format("{}: {}", type, error.message));
  };
  const std::uint64_t connectivityAt = record_.connectivity();
  auto connectivity = file_->readPartly(connectivityAt, kConnectivity);
  if (!connectivity) return connectivity.error();
  connectivityPayload_ = std::move(*connectivity);
  PayloadReader fromConnectivity(connectivityPayload_.view());
  auto connectivityFront = takeConnectivityFront(fromConnectivity, features_);
  if (!connectivityFront) return wrong(connectivityAt, "CONN", connectivityFront.error());
  connectivity_ = std::move(*connectivityFront);
  if (connectivity_.means > 0 || connectivity_.attributes > 0) return false;
  if (auto end = checkEnd(fromConnectivity); !end) {
    return wrong(connectivityAt, "CONN", end.error());
  }
  static_cast<model::VertexCounts&>(*this) = connectivity_.counts;

  auto slab = file_->readPartly(record_.slab, kSlab);
  if (!slab) return slab.error();
  slabPayload_ = std::move(*slab);
  PayloadReader fromSlab(slabPayload_.view());
  auto slabFront = takeSlabFront(fromSlab, features_);
  if (!slabFront) return wrong(record_.slab, "SLAB", slabFront.error());
  slab_ = std::move(*slabFront);
  if (slab_.attributes > 0 || slab_.cellBounds.empty()) return false;
  if (auto end = checkEnd(fromSlab); !end) return wrong(record_.slab, "SLAB", end.error());
  time = slab_.time;
  parts_[1] = {&slabPayload_, slab_.positions, slab_.times, 0, record_.slab};

  for (const std::size_t i : {0U, 1U}) {
    const std::uint64_t offset = i == 0 ? record_.lower() : record_.upper();
    if (offset == 0) continue;
    if (features_.pose) {
      const auto header = file_->readChunkHeader(offset);
      if (!header) return header.error();
      if (header->type == kPose) return false;
    }
    auto layer = file_->readPartly(offset, kLayer);
    if (!layer) return layer.error();
    layerPayloads_[i] = std::move(*layer);
    PayloadReader fromLayer(layerPayloads_[i].view());
    const auto front = takeLayerFront(fromLayer, features_);
    if (!front) return wrong(offset, "LAYR", front.error());
    if (front->attributes > 0) return false;
    if (auto end = checkEnd(fromLayer); !end) return wrong(offset, "LAYR", end.error());
    parts_[2 * i] = {&layerPayloads_[i], front->positions, {}, front->time, offset};
  }
  if (auto sound = checkParts(); !sound) return sound.error();
  return true;
}

/// Everything that can be checked without the blocks.
Result<void> FileSlab::checkParts() const {
  const auto wrong = [&](const std::string& message) {
    return file_->damaged(record_.slab, "SLAB: " + message);
  };
  if (!(record_ ==
        IndexRecord{record_.slab, slabPayload_.header().bytes(), slab_.parts, slab_.time})) {
    return wrong("the index says something else than the slab itself");
  }
  if (connectivity_.cells.rows != record_.extent->cells) {
    return wrong("the index says other cells or bounds than the slab has");
  }
  if (std::uint64_t{lowerCount} + upperCount > vertexCount) {
    return file_->damaged(record_.connectivity(),
                          fmt::format("CONN: layers of {} and {} vertices exceed the {} vertices",
                                      lowerCount, upperCount, vertexCount));
  }
  const std::uint64_t interior = firstUpper() - lowerCount;
  const auto rows = [&](std::size_t part) { return parts_[part].positions.rows; };
  if (rows(0) != lowerCount || rows(1) != interior || rows(2) != upperCount) {
    return wrong(
        fmt::format("its connectivity has {} lower, {} interior and {} upper vertices, "
                    "the file {}, {} and {}",
                    lowerCount, interior, upperCount, rows(0), rows(1), rows(2)));
  }
  const std::size_t blocks = connectivity_.cells.blocks.size();
  if (connectivity_.ranges.size() != blocks || slab_.cellBounds.size() != blocks) {
    return wrong(fmt::format("it has {} blocks of cells, but ranges of {} and bounds of {}", blocks,
                             connectivity_.ranges.size(), slab_.cellBounds.size()));
  }
  return {};
}

std::uint32_t FileSlab::firstOf(std::size_t part) const {
  return part == 0 ? 0 : part == 1 ? lowerCount : firstUpper();
}

Result<FileSlab::Vertices> FileSlab::unpackVertices(std::size_t part, std::size_t block) const {
  const Part& from = parts_[part];
  const auto wrong = [&](const Error& error) {
    return file_->damaged(from.offset,
                          fmt::format("{}: {}", part == 1 ? "SLAB" : "LAYR", error.message));
  };
  if (auto loaded = from.payload->load(from.positions.blocks[block]); !loaded) {
    return loaded.error();
  }
  const std::uint64_t first = block * kBlockRows;
  auto vertices =
      std::make_shared<std::vector<Point4>>(std::min(kBlockRows, from.positions.rows - first));
  if (auto set = unpackPositions(from.positions, block, *vertices, features_); !set) {
    return wrong(set.error());
  }
  if (from.times) {
    if (auto loaded = from.payload->load(from.times->blocks[block]); !loaded) {
      return loaded.error();
    }
    std::vector<double> times(vertices->size());
    if (auto set = unpackBlock(*from.times, block, std::as_writable_bytes(std::span(times)));
        !set) {
      return wrong(set.error());
    }
    for (std::size_t i = 0; i < times.size(); ++i) (*vertices)[i][3] = times[i];
  } else {
    for (Point4& vertex : *vertices) vertex[3] = from.time;
  }
  const auto number = firstOf(part) + static_cast<std::uint32_t>(first);
  if (auto sound = model::checkVertices(*vertices, *this, time, number); !sound) {
    return file_->damaged(record_.slab, "SLAB: " + sound.error().message);
  }
  return vertices;
}

Result<FileSlab::Vertices> FileSlab::vertices(std::size_t part, std::size_t block) const {
  const auto wanted = [&](const Cache::Entry& entry) {
    return entry.part == part && entry.block == block;
  };
  {
    const std::scoped_lock lock(cache_->mutex);
    const auto found = std::ranges::find_if(cache_->entries, wanted);
    if (found != cache_->entries.end()) {
      cache_->entries.splice(cache_->entries.begin(), cache_->entries, found);
      return cache_->entries.front().vertices;
    }
  }
  auto made = unpackVertices(part, block);
  if (!made) return made;
  const std::scoped_lock lock(cache_->mutex);
  if (std::ranges::none_of(cache_->entries, wanted)) {
    cache_->entries.push_front({part, block, *made});
    if (cache_->entries.size() > Cache::kMost) cache_->entries.pop_back();
  }
  return made;
}

Result<CellBlock> FileSlab::read(std::size_t number) const {
  const auto wrong = [&](const std::string& message) {
    return file_->damaged(record_.connectivity(), "CONN: " + message);
  };
  CellBlock block;
  const std::uint64_t first = number * kBlockRows;
  block.cells.resize(std::min(kBlockRows, connectivity_.cells.rows - first));
  if (auto loaded = connectivityPayload_.load(connectivity_.cells.blocks[number]); !loaded) {
    return loaded.error();
  }
  if (auto set =
          unpackBlock(connectivity_.cells, number, std::as_writable_bytes(std::span(block.cells)));
      !set) {
    return wrong(set.error().message);
  }
  if (auto sound = model::checkCells(block.cells, vertexCount, first); !sound) {
    return wrong(sound.error().message);
  }
  if (rangesOf(block.cells, *this) != connectivity_.ranges[number]) {
    return wrong("the ranges of vertices of its blocks are not those of their cells");
  }
  std::array<std::uint32_t, 3> firstLocal{};  // number in the block of the first of each range
  for (std::size_t part = 0; part < 3; ++part) {
    const auto begin = connectivity_.ranges[number][2 * part];
    const auto end = connectivity_.ranges[number][2 * part + 1];
    block.ranges[part] = {begin, end};
    firstLocal[part] = static_cast<std::uint32_t>(block.vertices.size());
    for (std::uint32_t at = begin; at < end;) {
      const std::uint32_t inPart = at - firstOf(part);
      const auto piece = vertices(part, inPart / kBlockRows);
      if (!piece) return piece.error();
      const std::uint32_t from = inPart % kBlockRows;
      const auto count = std::min<std::uint32_t>(end - at, (*piece)->size() - from);
      block.vertices.insert(block.vertices.end(), (*piece)->begin() + from,
                            (*piece)->begin() + from + count);
      at += count;
    }
  }
  model::Bounds4 bounds;
  for (Cell& cell : block.cells) {
    for (std::uint32_t& vertex : cell) {
      const std::size_t part = vertex < lowerCount ? 0 : vertex < firstUpper() ? 1 : 2;
      vertex = vertex - block.ranges[part].begin + firstLocal[part];
      bounds.add(block.vertices[vertex]);
    }
  }
  if (bounds.min != slab_.cellBounds[number].min || bounds.max != slab_.cellBounds[number].max) {
    return file_->damaged(
        record_.slab, "SLAB: the bounds of its blocks of cells are not those of their vertices");
  }
  return block;
}

}  // namespace t4d::formats
