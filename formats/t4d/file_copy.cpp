#include "formats/t4d/file_copy.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/chunk_counts.h"
#include "formats/t4d/ending.h"
#include "formats/t4d/file_scan.h"
#include "formats/t4d/metadata.h"
#include "formats/t4d/slab_source.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

Result<void> checkSums(const CopiedFile& file, const SlabList& slabs) {
  std::vector<SlabExtent> sums(file.bodies.size());
  for (const IndexRecord& record : file.slabs.of(slabs)) {
    SlabExtent& sum = sums[record.parts.body];
    sum.cells += record.extent->cells;
    sum.bounds.add(record.extent->bounds);
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const BodySummary& said = file.bodies[i];
    if (sums[i] == SlabExtent{said.tetrahedra, said.bounds}) continue;
    return invalid(fmt::format("DONE: body {} has {} cells in its slabs, or other bounds than it "
                               "says; it says {} cells",
                               i, sums[i].cells, said.tetrahedra),
                   file.path.string());
  }
  return {};
}

}  // namespace

Result<CopiedFile> readForCopy(const std::filesystem::path& path, CopiedChunks& into,
                               const model::Progress& progress) {
  auto file = ChunkFile::open(path);
  if (!file) return file.error();
  auto beginning = readBeginning(*file);
  if (!beginning) return beginning.error();
  const Head& head = beginning->head;
  FileScan scan =
      scanFile(*file, head.header.end(), head.metadata.bodies.size(), head.features, progress);
  if (scan.damage) return *scan.damage;
  auto slabs = readTail(*file, beginning->header, head, scan);
  if (!slabs) return slabs.error();
  CopiedFile copied{path,
                    std::move(beginning->head),
                    {into.chunks.size(), scan.chunks.size()},
                    {into.slabs.size(), slabs->size()},
                    std::move(scan.done->bodies),
                    {}};
  // One source for all, which keeps the parts that slabs share.
  const SlabSource source(*file, copied.head.features);
  for (IndexRecord record : slabs->all()) {
    if (!record.extent) {
      const auto slab = source.read(record);
      if (!slab) return slab.error();
      record.extent = extentOf(**slab);
    }
    into.slabs.push_back(record);
  }
  addChunk(copied.sums, kHead, copied.head.header.bytes());
  for (const ChunkHeader& chunk : scan.chunks.all()) {
    into.chunks.push_back(chunk);
    addChunk(copied.sums, chunk.type, chunk.bytes());
  }
  addChunk(copied.sums, kDone, scan.end - scan.doneOffset);
  if (beginning->header.indexed) {
    addChunk(copied.sums, kIndex, file->size() - kFooterBytes - scan.end);
  }
  if (auto sums = checkSums(copied, into.slabs); !sums) return sums.error();
  return copied;
}

Result<CopiedFile> readIndexForCopy(const std::filesystem::path& path, CopiedChunks& into) {
  const auto file = ChunkFile::open(path);
  if (!file) return file.error();
  auto beginning = readBeginning(*file);
  if (!beginning) return beginning.error();
  auto ending = readEnding(*file, beginning->head.features);
  if (!ending) return ending.error();
  if (auto checked = checkEnding(*file, *ending, beginning->header, beginning->head); !checked) {
    return checked.error();
  }
  CopiedFile known{path,
                   std::move(beginning->head),
                   {into.chunks.size(), 0},
                   {into.slabs.size(), ending->index.slabs.size()},
                   std::move(ending->done.bodies),
                   {}};
  for (const ChunkHeader& chunk : ending->index.chunks) {
    if (chunk.type != kHead && chunk.type != t4d_layout::kDone) into.chunks.push_back(chunk);
  }
  known.chunks.count = into.chunks.size() - known.chunks.first;
  for (const IndexRecord& record : ending->index.slabs) into.slabs.push_back(record);
  return known;
}

std::optional<std::string> differingAttribute(const Metadata& one, const Metadata& other) {
  for (const auto& [name, meaning] : one.attributes) {
    const auto found = other.attributes.find(name);
    if (found != other.attributes.end() && found->second != meaning) return name;
  }
  return std::nullopt;
}

Result<ChunkFile::Chunk> readForCopy(const ChunkFile& from, const ChunkHeader& known) {
  auto chunk = from.readChunk(known.offset, known.type);
  if (chunk && chunk->header != known) {
    return from.damaged(known.offset, "the file has changed while it was read");
  }
  return chunk;
}

Result<void> copyChunks(const ChunkFile& file, const CopiedFile& from, const CopiedChunks& all,
                        const PutChunk& put, CopyState& state,
                        const std::function<Result<void>()>& one) {
  const auto isLeftOut = [&](const ChunkHeader& chunk) {
    if (chunk.type == kPage || chunk.type == kPageList) return true;  // made anew
    if (!isUnknown(chunk.type)) return false;
    const auto bytes = encodeChunkHeader(chunk);
    const std::string header(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const bool safe = isSafeToCopy(chunk.type);
    if (!safe) state.lost.add(chunk);
    return !safe || !state.kept.insert(header).second;
  };
  std::size_t slab = from.slabs.first;
  for (const ChunkHeader& known : from.chunks.of(all.chunks)) {
    if (!isLeftOut(known)) {
      auto chunk = readForCopy(file, known);
      if (!chunk) return chunk.error();
      std::optional<IndexRecord> record;
      if (known.type == kSlab) record = all.slabs[slab++];
      if (auto done = put(*chunk, record ? &*record : nullptr); !done) return done;
    }
    if (auto on = one(); !on) return on;
  }
  return {};
}

Result<CopyHead> headOfCopy(const Metadata& metadata, std::span<const CopiedFile> files) {
  std::vector<std::string> features;
  std::optional<Grid> grid;
  for (const CopiedFile& file : files) {
    for (const std::string& feature : file.metadata().features) {
      if (std::ranges::find(features, feature) == features.end()) features.push_back(feature);
    }
    if (!grid) grid = file.metadata().grid;
  }
  auto head = headText(metadata, features, grid);
  if (!head) return head.error();
  return CopyHead{std::move(*head), std::ranges::find(features, kFeatureZstd) != features.end()};
}

Result<ChunkWriter> beginCopy(const std::filesystem::path& into, const Metadata& metadata,
                              std::span<const CopiedFile> files) {
  const auto head = headOfCopy(metadata, files);
  if (!head) return head.error();
  auto out = OutputFile::create(into);
  if (!out) return out.error();
  constexpr int kIndexLevel = 3;
  ChunkWriter chunks(std::move(*out), true, head->zstd ? kIndexLevel : 0);
  if (auto begun = chunks.begin(head->text, minorVersionFor(metadata)); !begun) {
    return begun.error();
  }
  return chunks;
}

}  // namespace t4d::formats
