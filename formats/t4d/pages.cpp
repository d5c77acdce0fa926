#include "formats/t4d/pages.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "formats/t4d/chunk_counts.h"
#include "formats/t4d/chunk_fields.h"
#include "formats/t4d/part_window.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

constexpr std::size_t kPageBodyBytes = 72;
constexpr std::size_t kLengthBytes = sizeof(std::uint64_t);

bool haveTheSame(const std::vector<T4dChunks>& a, const std::vector<T4dChunks>& b) {
  return std::ranges::is_permutation(a, b, [](const T4dChunks& one, const T4dChunks& other) {
    return one.type == other.type && one.count == other.count && one.bytes == other.bytes;
  });
}

/// The chunks that those to come may name.
class NameableChunks {
 public:
  explicit NameableChunks(std::size_t bodyCount) : window_(bodyCount) {}

  /// Call in file order; with the record of a SLAB, too.
  void add(const ChunkHeader& chunk) { window_.add(chunk); }
  void add(const IndexRecord& slab) {
    const ChunkHeader* upper = window_.findLayer(slab.upper());
    if (upper != nullptr) uppers_[slab.parts.body] = *upper;
  }
  std::vector<ChunkHeader> inOrder() const {
    std::vector<ChunkHeader> all = window_.chunks();
    for (const auto& [body, upper] : uppers_) all.push_back(upper);
    std::ranges::sort(all, {}, &ChunkHeader::offset);
    const auto same = std::ranges::unique(all);
    all.erase(same.begin(), same.end());
    return all;
  }

 private:
  PartWindow window_;
  std::map<std::uint32_t, ChunkHeader> uppers_;  // of the last slab of each body
};

std::vector<PageBody> bodiesOf(const std::vector<IndexRecord>& slabs) {
  std::map<std::uint32_t, PageBody> bodies;
  for (const IndexRecord& slab : slabs) {
    PageBody& body = bodies[slab.parts.body];
    body.body = slab.parts.body;
    if (body.slabs++ == 0) body.time.begin = slab.time.begin;
    body.time.end = slab.time.end;
    body.bounds.add(slab.extent->bounds);
  }
  std::vector<PageBody> list;
  for (const auto& [number, body] : bodies) list.push_back(body);
  return list;
}

bool isSame(const model::Bounds3& a, const model::Bounds3& b) {
  return a.min == b.min && a.max == b.max;
}

bool isSame(const PageBody& a, const PageBody& b) {
  return a.body == b.body && a.slabs == b.slabs && a.time.begin == b.time.begin &&
         a.time.end == b.time.end && isSame(a.bounds, b.bounds);
}

void putPoint(ByteWriter& into, const model::Point3& point) {
  for (const double number : point) into.put(number);
}

model::Point3 takePoint(ByteReader& from) {
  model::Point3 point;
  for (double& number : point) number = from.take<double>();
  return point;
}

void putHeader(ByteWriter& into, const ChunkHeader& header) {
  const ChunkHeaderBytes bytes = encodeChunkHeader(header);
  into.putBytes(bytes.data(), kDirectoryEntryBytes);
}

PageBody takePageBody(ByteReader& from) {
  PageBody body;
  body.body = from.take<std::uint32_t>();
  body.slabs = from.take<std::uint32_t>();
  body.time = takeTime(from);
  body.bounds.min = takePoint(from);
  body.bounds.max = takePoint(from);
  return body;
}

/// `list` is at `offset`, and its pages before it.
Result<PageList> decodePageList(const PayloadView& payload, std::uint64_t offset) {
  ByteReader from(payload.fields);
  PageList list;
  list.offset = offset;
  const auto head = from.takeBytes(kDirectoryEntryBytes);
  if (from.overrun()) return cutOff("the list of pages");
  list.head = decodeChunkHeader(head.first<kDirectoryEntryBytes>(), kFileHeaderBytes);
  const auto types = from.take<std::uint32_t>();
  const auto pages = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  for (std::uint32_t i = 0; i < types && !from.overrun(); ++i) {
    ChunkType type{};
    for (char& letter : type) letter = from.take<char>();
    if (from.take<std::uint32_t>() != 0) return invalid("its reserved bytes are not zero");
    T4dChunks sums{std::string(type.begin(), type.end())};
    sums.count = from.take<std::uint64_t>();
    sums.bytes = from.take<std::uint64_t>();
    list.chunks.push_back(std::move(sums));
  }
  for (std::uint32_t i = 0; i < pages && !from.overrun(); ++i) {
    PageEntry entry;
    const auto distance = from.take<std::uint64_t>();
    entry.checksum = from.take<std::uint32_t>();
    const auto bodies = from.take<std::uint32_t>();
    if (bodies > from.left() / kPageBodyBytes) return cutOff("the list of pages");
    if (distance == 0 || distance >= offset) {
      return invalid(fmt::format("page {} is {} bytes before it", i, distance));
    }
    entry.offset = offset - distance;
    for (std::uint32_t k = 0; k < bodies; ++k) entry.bodies.push_back(takePageBody(from));
    list.pages.push_back(std::move(entry));
  }
  from.takeBytes(kLengthBytes);  // of itself, by which it was found
  if (from.overrun()) return cutOff("the list of pages");
  if (from.left() > 0) return invalid("it goes on behind its last field");
  return list;
}

/// The pages together must have what DONE says.
Result<void> checkAgainst(const PageList& list, const std::vector<BodySummary>& bodies) {
  std::vector<BodySummary> found(bodies.size());
  for (std::size_t i = 0; i < list.pages.size(); ++i) {
    for (const PageBody& entry : list.pages[i].bodies) {
      if (entry.body >= bodies.size() || entry.slabs == 0) {
        return invalid(fmt::format("page {} has {} slabs of body {}, of {}", i, entry.slabs,
                                   entry.body, bodies.size()));
      }
      if (auto sound = checkTime(entry.time); !sound) return sound;
      BodySummary& body = found[entry.body];
      const bool first = body.slabs == 0;
      if (!first && entry.time.begin < body.time.end) {
        return invalid(fmt::format("page {} begins body {} at time {}, that before ends at {}", i,
                                   entry.body, entry.time.begin, body.time.end));
      }
      body.time = {first ? entry.time.begin : body.time.begin, entry.time.end};
      body.slabs += entry.slabs;
      body.bounds.add(entry.bounds);
    }
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodySummary& said = bodies[i];
    if (found[i].slabs == said.slabs && found[i].time.begin == said.time.begin &&
        found[i].time.end == said.time.end && isSame(found[i].bounds, said.bounds)) {
      continue;
    }
    return invalid(
        fmt::format("body {} has {} slabs in its pages, or other times or bounds than "
                    "DONE says; it says {} slabs",
                    i, found[i].slabs, said.slabs));
  }
  return {};
}

Result<Page> decodePage(const PayloadView& payload, const Features& features,
                        std::uint64_t offset) {
  PayloadReader from(payload);
  const auto distance = from.take<std::uint64_t>();
  const auto slabs = from.take<std::uint32_t>();
  const auto reserved = from.take<std::uint32_t>();
  if (from.overrun()) return cutOff("the page");
  if (reserved != 0) return invalid("its reserved bytes are not zero");
  if (distance == 0 || distance > offset) {
    return invalid(fmt::format("its chunks begin {} bytes before it", distance));
  }
  const std::uint64_t begin = offset - distance;
  auto places = takeArrayOf(from, model::ScalarType::UInt64, 1, features);
  if (!places) return places.error();
  auto earlier = takeHeaders(from, features, 0);
  if (!earlier) return earlier.error();
  auto chunks = takeHeaders(from, features, begin);
  if (!chunks) return chunks.error();
  Page page;
  if (places->rows != earlier->size()) return invalid("it has not a place for each chunk before");
  for (std::size_t i = 0; i < earlier->size(); ++i) {
    std::uint64_t back = 0;
    std::memcpy(&back, places->bytes.data() + i * sizeof back, sizeof back);
    ChunkHeader header = (*earlier)[i];
    header.offset = begin - back;
    const bool sorted = page.chunks.empty() || header.offset > page.chunks.back().offset;
    if (back == 0 || back > begin || !sorted) {
      return invalid(fmt::format("a chunk before its own is {} bytes before them", back));
    }
    page.chunks.push_back(header);
  }
  page.chunks.insert(page.chunks.end(), chunks->begin(), chunks->end());
  if (slabs > chunks->size()) {
    return invalid(fmt::format("it has {} slabs among {} chunks", slabs, chunks->size()));
  }
  page.slabs.resize(slabs);
  auto taken = takeSlabs(from, page.slabs, features);
  if (taken) taken = checkEnd(from);
  if (taken) taken = placeSlabs(page.chunks, page.slabs);
  if (!taken) return taken.error();
  return page;
}

/// Slabs of a body follow one another in time, and are what the list says.
Result<void> checkSlabs(const Page& page, const PageEntry& entry) {
  std::map<std::uint32_t, double> ends;
  for (const IndexRecord& slab : page.slabs) {
    if (auto sound = checkTime(slab.time); !sound) return sound;
    const auto [end, first] = ends.try_emplace(slab.parts.body, slab.time.end);
    if (!first && slab.time.begin < end->second) {
      return invalid(fmt::format("the slab at byte {} begins at time {}, the one before ends at {}",
                                 slab.slab, slab.time.begin, end->second));
    }
    end->second = slab.time.end;
  }
  const std::vector<PageBody> found = bodiesOf(page.slabs);
  const auto same = [](const PageBody& a, const PageBody& b) { return isSame(a, b); };
  if (std::ranges::equal(found, entry.bodies, same)) return {};
  return invalid("its slabs are not those that the list of pages says");
}

}  // namespace

Result<void> eachPageRun(const ChunkList& chunks, const SlabList& slabs, std::size_t bodyCount,
                         std::size_t pageSlabs,
                         const std::function<Result<void>(const PageRun& run)>& use) {
  const std::size_t slabCount = slabs.size();
  const std::size_t chunkCount = chunks.size();
  if (bodyCount > kMostPagedBodies || slabCount < kLeastPages * pageSlabs) return {};
  NameableChunks nameable(bodyCount);
  std::size_t slab = 0;
  PageRun run;
  for (std::size_t i = 1; i < chunkCount; ++i) {
    run.chunks.push_back(chunks[i]);
    nameable.add(run.chunks.back());
    if (run.chunks.back().type == kSlab) {
      run.slabs.push_back(slabs[slab++]);
      nameable.add(run.slabs.back());
    }
    // Chunks after the last slab are in its page.
    const bool isFull = run.slabs.size() == pageSlabs && slab < slabCount;
    if (!isFull && i + 1 < chunkCount) continue;
    if (auto used = use(run); !used) return used;
    run = {nameable.inOrder(), {}, {}};
  }
  return {};
}

PayloadWriter encodePage(const PageRun& run, std::uint64_t offset, int level) {
  PayloadWriter payload;
  const std::uint64_t begin = run.chunks.front().offset;
  payload.put(offset - begin);
  payload.put(static_cast<std::uint32_t>(run.slabs.size()));
  payload.put(std::uint32_t{0});
  std::vector<std::uint64_t> places;
  for (const ChunkHeader& chunk : run.earlier) places.push_back(begin - chunk.offset);
  putArray(payload, viewOf(places), level);
  putHeaders(payload, rowsOf(run.earlier), level);
  putHeaders(payload, rowsOf(run.chunks), level);
  putSlabs(payload, rowsOf(run.slabs), level);
  return payload;
}

PageEntry entryOf(const PageRun& run, std::uint64_t offset) {
  return {offset, 0, bodiesOf(run.slabs)};
}

PayloadWriter encodePageList(const PageList& list) {
  PayloadWriter payload;
  putHeader(payload, list.head);
  payload.put(static_cast<std::uint32_t>(list.chunks.size()));
  payload.put(static_cast<std::uint32_t>(list.pages.size()));
  payload.put(std::uint32_t{0});
  for (const T4dChunks& sums : list.chunks) {
    payload.putBytes(sums.type.data(), sizeof(ChunkType));
    payload.put(std::uint32_t{0});
    payload.put(sums.count);
    payload.put(sums.bytes);
  }
  for (const PageEntry& entry : list.pages) {
    payload.put(list.offset - entry.offset);
    payload.put(entry.checksum);
    payload.put(static_cast<std::uint32_t>(entry.bodies.size()));
    for (const PageBody& body : entry.bodies) {
      payload.put(body.body);
      payload.put(body.slabs);
      putTime(payload, body.time);
      putPoint(payload, body.bounds.min);
      putPoint(payload, body.bounds.max);
    }
  }
  payload.put(std::uint64_t{kChunkHeaderBytes + payload.size() + kLengthBytes});
  return payload;
}

Result<std::optional<PageList>> readPageList(const ChunkFile& file, std::uint64_t done,
                                             const std::vector<BodySummary>& bodies) {
  const auto end = file.readLength(done);
  if (!end) return end.error();
  // Other files may have any bytes here.
  if (*end % kAlignment != 0 || *end < kChunkHeaderBytes || *end > done - kFileHeaderBytes) {
    return std::nullopt;
  }
  const std::uint64_t offset = done - *end;
  const auto header = file.readChunkHeader(offset);
  if (!header) {
    if (header.error().code == ErrorCode::Io) return header.error();
    return std::nullopt;
  }
  if (header->type != kPageList || header->end() != done) return std::nullopt;
  const auto wrong = [&](const Error& error) {
    return file.damaged(offset, "PGIX: " + error.message);
  };
  const auto payload = file.readPayload(*header);
  if (!payload) return payload.error();
  if (header->blocks > 0) return wrong({ErrorCode::InvalidInput, "it has blocks"});
  auto list = decodePageList(payload->view, offset);
  if (!list) return wrong(list.error());
  if (auto same = checkAgainst(*list, bodies); !same) return wrong(same.error());
  return std::optional(std::move(*list));
}

Result<Page> readPage(const ChunkFile& file, const PageList& list, std::size_t number,
                      const Features& features) {
  const PageEntry& entry = list.pages[number];
  // A writer puts them one after another.
  std::uint64_t next = list.offset;
  if (number + 1 < list.pages.size() && list.pages[number + 1].offset > entry.offset) {
    next = list.pages[number + 1].offset;
  }
  file.plan(std::array{ByteRange{entry.offset, next}});
  const auto chunk = file.readChunk(entry.offset, kPage);
  if (!chunk) return chunk.error();
  const auto wrong = [&](const Error& error) {
    return file.damaged(entry.offset, "PAGE: " + error.message);
  };
  if (checksumOf(chunk->header) != entry.checksum) {
    return wrong({ErrorCode::InvalidInput, "it is not the page that the list of pages names"});
  }
  auto page = decodePage(chunk->payload.view, features, entry.offset);
  if (!page) return wrong(page.error());
  if (auto sound = checkSlabs(*page, entry); !sound) return wrong(sound.error());
  return page;
}

Result<SlabList> checkPages(const ChunkFile& file, const PageList& list, const ChunkList& chunks,
                            const SlabList& slabs, const Features& features) {
  std::vector<T4dChunks> sums;
  addChunk(sums, kHead, list.head.bytes());
  std::size_t pageCount = 0;
  for (const ChunkHeader& chunk : chunks.all()) {
    if (chunk.type != kPageList) addChunk(sums, chunk.type, chunk.bytes());
    pageCount += chunk.type == kPage;
  }
  if (!haveTheSame(sums, list.chunks)) {
    return file.damaged(list.offset, "PGIX: its numbers of chunks are not those of the file");
  }
  SlabList said;
  NameableChunks nameable(kMostPagedBodies);
  std::size_t next = 0;  // of the chunks that are in no page so far
  std::size_t slab = 0;  // the next of the slabs among them
  for (std::size_t i = 0; i < list.pages.size(); ++i) {
    const auto page = readPage(file, list, i, features);
    if (!page) return page.error();
    const auto wrong = [&](const std::string& message) {
      return file.damaged(list.pages[i].offset, "PAGE: " + message);
    };
    const std::vector<ChunkHeader> earlier = nameable.inOrder();
    for (const ChunkHeader& chunk : page->chunks) {
      if (next < chunks.size() && chunks[next] == chunk) {
        ++next;
        nameable.add(chunk);
        if (chunk.type == kSlab) nameable.add(slabs[slab++]);
        continue;
      }
      const auto found = std::ranges::lower_bound(earlier, chunk.offset, {}, &ChunkHeader::offset);
      if (found != earlier.end() && *found == chunk) continue;
      return wrong("its headers of chunks are not those of the file");
    }
    for (const IndexRecord& record : page->slabs) {
      if (said.size() == slabs.size() || !(record == slabs[said.size()])) {
        return wrong(fmt::format("it says something else of the slab at byte {}", record.slab));
      }
      said.push_back(record);
    }
  }
  // The chunks in pages are followed by the pages and PGIX.
  if (said.size() == slabs.size() && next + pageCount + 1 == chunks.size()) return said;
  return file.damaged(list.offset, "PGIX: its pages do not have all chunks");
}

}  // namespace t4d::formats
