#include "t4d/formats/t4d/file_copy.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/formats/t4d/ending.h"
#include "t4d/formats/t4d/file_scan.h"
#include "t4d/formats/t4d/slab_source.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

Result<void> checkSums(const CopiedFile& file) {
  std::vector<SlabExtent> sums(file.bodies.size());
  for (const IndexRecord& record : file.slabs) {
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

Result<CopiedFile> readForCopy(const std::filesystem::path& path, const model::Progress& progress) {
  auto file = ChunkFile::open(path);
  if (!file) return pass(file.error());
  auto beginning = readBeginning(*file);
  if (!beginning) return pass(beginning.error());
  const Head& head = beginning->head;
  FileScan scan =
      scanFile(*file, head.header.end(), head.metadata.bodies.size(), head.features, progress);
  if (scan.damage) return pass(*scan.damage);
  auto slabs = readTail(*file, beginning->header, head, scan);
  if (!slabs) return pass(slabs.error());
  // One source for all, which keeps the parts that slabs share.
  const SlabSource source(*file, head.features);
  for (IndexRecord& record : *slabs) {
    if (record.extent) continue;
    const auto slab = source.read(record);
    if (!slab) return pass(slab.error());
    record.extent = extentOf(**slab);
  }
  CopiedFile copied{path, std::move(beginning->head), std::move(scan.chunks), std::move(*slabs),
                    std::move(scan.done->bodies)};
  if (auto sums = checkSums(copied); !sums) return pass(sums.error());
  return copied;
}

std::optional<std::string> differingAttribute(const Metadata& one, const Metadata& other) {
  for (const auto& [name, meaning] : one.attributes) {
    const auto found = other.attributes.find(name);
    if (found != other.attributes.end() && found->second != meaning) return name;
  }
  return std::nullopt;
}

Result<void> copyChunks(ChunkFile& file, const CopiedFile& from, const PutChunk& put,
                        CopyState& state, const std::function<void()>& one) {
  file.expectChunks(from.chunks);
  auto slab = from.slabs.begin();
  for (const ChunkHeader& known : from.chunks) {
    if (isUnknown(known.type)) {
      const auto bytes = encodeChunkHeader(known);
      const std::string header(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      const bool safe = isSafeToCopy(known.type);
      if (!safe) state.lost.add(known);
      if (!safe || !state.kept.insert(header).second) {
        one();
        continue;
      }
    }
    auto chunk = file.readChunk(known.offset, known.type);
    if (!chunk) return pass(chunk.error());
    if (auto done = put(*chunk, known.type == kSlab ? &*slab++ : nullptr); !done) return done;
    one();
  }
  return {};
}

Result<ChunkWriter> beginCopy(const std::filesystem::path& into, const Metadata& metadata,
                              std::span<const CopiedFile> files) {
  std::vector<std::string> features;
  std::optional<Grid> grid;
  for (const CopiedFile& file : files) {
    for (const std::string& feature : file.metadata().features) {
      if (std::ranges::find(features, feature) == features.end()) features.push_back(feature);
    }
    if (!grid) grid = file.metadata().grid;
  }
  const auto head = headText(metadata, features, grid);
  if (!head) return pass(head.error());
  auto out = OutputFile::create(into);
  if (!out) return pass(out.error());
  const bool zstd = std::ranges::find(features, kFeatureZstd) != features.end();
  constexpr int kIndexLevel = 3;
  ChunkWriter chunks(std::move(*out), true, zstd ? kIndexLevel : 0);
  if (auto begun = chunks.begin(*head, minorVersionFor(metadata)); !begun) {
    return pass(begun.error());
  }
  return chunks;
}

}  // namespace t4d::formats
