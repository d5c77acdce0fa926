#include "t4d/formats/t4d/join.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>

#include <fmt/format.h>

#include "t4d/formats/t4d/chunk_writer.h"
#include "t4d/formats/t4d/ending.h"
#include "t4d/formats/t4d/file_scan.h"
#include "t4d/formats/t4d/optional_chunks.h"
#include "t4d/formats/t4d/part_copier.h"
#include "t4d/formats/t4d/slab_source.h"
#include "t4d/formats/t4d/within_memory.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

/// A file to be joined, with all its chunks checked.
struct Part {
  std::filesystem::path path;
  Head head;
  std::vector<ChunkHeader> chunks;  // between HEAD and DONE
  std::vector<IndexRecord> slabs;   // all have an extent
  std::vector<BodySummary> bodies;
  std::vector<std::uint64_t> lowers = {};  // of bodies that continue, where their first layers are

  const Metadata& metadata() const { return head.metadata; }
};

Result<Part> readPart(const std::filesystem::path& path, const model::Progress& progress) {
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
  return Part{path, std::move(beginning->head), std::move(scan.chunks), std::move(*slabs),
              std::move(scan.done->bodies)};
}

/// What the next part of a body must continue.
struct End {
  double time = 0;
  std::optional<ChunkHeader> layer;  // of the upper layer of the last slab, its offset 0
};

class Joiner {
 public:
  /// Reads a part through, and checks that it continues those before.
  Result<void> add(const std::filesystem::path& path, const model::Progress& progress) {
    auto part = readPart(path, progress);
    if (!part) return pass(part.error());
    if (!parts_.empty()) {
      if (auto fits = checkMetadata(*part); !fits) return fits;
    }
    summaries_.resize(part->metadata().bodies.size());
    ends_.resize(summaries_.size());
    part->lowers.resize(summaries_.size());
    std::vector<bool> begun(summaries_.size());
    for (const IndexRecord& record : part->slabs) {
      const std::uint32_t body = record.parts.body;
      if (!begun[body]) {
        if (auto fits = checkSeam(*part, record); !fits) return fits;
        begun[body] = true;
        if (!parts_.empty()) part->lowers[body] = record.lower();
      }
      ends_[body] = {record.time.end, headerAt(*part, record.upper())};
    }
    if (auto sums = checkSums(*part); !sums) return sums;
    for (std::size_t i = 0; i < summaries_.size(); ++i) addSummary(i, part->bodies[i]);
    parts_.push_back(std::move(*part));
    return {};
  }

  Result<JoinReport> write(const std::filesystem::path& into, const model::Progress& progress) {
    const Metadata& first = parts_.front().metadata();
    std::vector<std::string> features = first.features;
    std::uint64_t count = 0;
    std::vector<const Metadata*> all;
    for (const Part& part : parts_) {
      all.push_back(&part.metadata());
      for (const std::string& feature : part.metadata().features) {
        if (std::ranges::find(features, feature) == features.end()) features.push_back(feature);
      }
      count += part.chunks.size();
    }
    std::vector<std::string> losses;
    const Metadata joined = joinedMetadata(all, losses);
    const auto head = headText(joined, features, first.grid);
    if (!head) return pass(head.error());
    auto out = OutputFile::create(into);
    if (!out) return pass(out.error());
    const bool zstd = std::ranges::find(features, kFeatureZstd) != features.end();
    constexpr int kIndexLevel = 3;
    ChunkWriter chunks(std::move(*out), true, zstd ? kIndexLevel : 0);
    if (auto begun = chunks.begin(*head, minorVersionFor(joined)); !begun)
      return pass(begun.error());
    std::uint64_t done = 0;
    LostChunks lost;
    std::set<std::string> kept;
    const bool posed = std::ranges::find(features, kFeaturePose) != features.end();
    PartCopier copier(chunks, summaries_.size(), posed);
    for (const Part& part : parts_) {
      const auto one = [&] {
        if (progress) progress(static_cast<double>(++done) / static_cast<double>(count));
      };
      if (auto copied = copy(part, chunks, copier, kept, lost, one); !copied) return pass(copied.error());
    }
    auto bytes = chunks.finish(summaries_);
    if (!bytes) return pass(bytes.error());
    for (std::string& line : lost.lines()) losses.push_back(std::move(line));
    return JoinReport{summaries_, *bytes, std::move(losses)};
  }

 private:
  static std::optional<ChunkHeader> headerAt(const Part& part, std::uint64_t offset) {
    if (offset == 0) return std::nullopt;
    const auto found = std::ranges::lower_bound(part.chunks, offset, {}, &ChunkHeader::offset);
    ChunkHeader header = *found;
    header.offset = 0;
    return header;
  }

  tl::unexpected<Error> unfit(const Part& part, const std::string& message) const {
    return fail(ErrorCode::InvalidInput, message + " of " + parts_.front().path.string(),
                part.path.string());
  }

  Result<void> checkMetadata(const Part& part) const {
    const Metadata& first = parts_.front().metadata();
    const Metadata& other = part.metadata();
    if (!std::ranges::equal(first.bodies, other.bodies, {}, &BodyInfo::name, &BodyInfo::name)) {
      return unfit(part, "cannot be joined: its bodies are not those");
    }
    if (first.lengthUnit != other.lengthUnit || first.timeUnit != other.timeUnit ||
        first.up != other.up || first.space != other.space) {
      return unfit(part,
                   "cannot be joined: its units, its space, or the axis that points up, are not "
                   "those");
    }
    for (const Part& before : parts_) {
      for (const auto& [name, meaning] : before.metadata().attributes) {
        const auto found = other.attributes.find(name);
        if (found == other.attributes.end() || found->second == meaning) continue;
        return unfit(part, fmt::format("cannot be joined: its attribute '{}' is not of the kind "
                                       "and the unit of that",
                                       name));
      }
    }
    if (first.grid != other.grid) {
      return unfit(part, "cannot be joined: the grid of its positions is not that");
    }
    return {};
  }

  /// `record` is the first of its body in `part`.
  Result<void> checkSeam(const Part& part, const IndexRecord& record) {
    if (parts_.empty()) return {};
    const End& end = ends_[record.parts.body];
    const std::string before = parts_.back().path.string();
    const auto wrong = [&](const std::string& message) {
      return fail(ErrorCode::InvalidInput,
                  fmt::format("cannot be joined after {}: the body '{}' {}", before,
                              part.metadata().bodies[record.parts.body].name, message),
                  part.path.string());
    };
    const auto lower = headerAt(part, record.lower());
    if (lower ? record.time.begin != end.time : record.time.begin < end.time) {
      return wrong(
          fmt::format("begins at time {}, and ends there at {}", record.time.begin, end.time));
    }
    if (lower.has_value() != end.layer.has_value()) {
      return wrong(lower ? "begins with a layer, and ends there without one"
                         : "begins without a layer, and ends there with one");
    }
    if (lower && (lower->type != kLayer || *lower != *end.layer)) {
      return wrong(
          "does not begin with the layer, stored in the same way, with which it ends there");
    }
    if (lower) {
      // These are in the summary of the part before.
      const auto vertices = layerSize(part, record.lower());
      if (!vertices) return pass(vertices.error());
      summaries_[record.parts.body].vertices -= *vertices;
    }
    return {};
  }

  /// Checks DONE against what the index, or the slabs without one, say of the slabs.
  static Result<void> checkSums(const Part& part) {
    std::vector<SlabExtent> sums(part.bodies.size());
    for (const IndexRecord& record : part.slabs) {
      SlabExtent& sum = sums[record.parts.body];
      sum.cells += record.extent->cells;
      sum.bounds.add(record.extent->bounds);
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const BodySummary& said = part.bodies[i];
      if (sums[i] == SlabExtent{said.tetrahedra, said.bounds}) continue;
      return invalid(fmt::format("DONE: body {} has {} cells in its slabs, or other bounds than it "
                                 "says; it says {} cells",
                                 i, sums[i].cells, said.tetrahedra),
                     part.path.string());
    }
    return {};
  }

  void addSummary(std::size_t body, const BodySummary& added) {
    if (added.slabs == 0) return;
    BodySummary& sum = summaries_[body];
    sum.time = {sum.slabs == 0 ? added.time.begin : sum.time.begin, added.time.end};
    sum.slabs += added.slabs;
    sum.vertices += added.vertices;
    sum.tetrahedra += added.tetrahedra;
    if (added.vertices > 0) sum.bounds.add(added.bounds);
  }

  static Result<std::uint64_t> layerSize(const Part& part, std::uint64_t offset) {
    const auto file = ChunkFile::open(part.path);
    if (!file) return pass(file.error());
    const auto chunk = file->readPartly(offset, kLayer);
    if (!chunk) return pass(chunk.error());
    PayloadReader from(chunk->view());
    const auto front = takeLayerFront(from, part.head.features);
    if (!front) return pass(front.error());
    return front->positions.rows;
  }

  static Result<void> putUnknown(const ChunkFile::Chunk& chunk, ChunkWriter& into) {
    const auto offset = into.putCopy(chunk.header, chunk.payload.bytes);
    return offset ? Result<void>() : pass(offset.error());
  }

  /// Copies the chunks between HEAD and DONE; calls `one` after each. `kept` has the headers of the
  /// chunks that this version does not know and that are copied, each once.
  template <class One>
  static Result<void> copy(const Part& part, ChunkWriter& into, PartCopier& copier,
                           std::set<std::string>& kept, LostChunks& lost, One one) {
    auto file = ChunkFile::open(part.path);
    if (!file) return pass(file.error());
    file->expectChunks(part.chunks);
    copier.begin(*file, part.lowers);
    auto slab = part.slabs.begin();
    for (const ChunkHeader& known : part.chunks) {
      if (isUnknown(known.type)) {
        const auto bytes = encodeChunkHeader(known);
        const std::string header(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        const bool safe = isSafeToCopy(known.type);
        if (!safe) lost.add(known);
        if (!safe || !kept.insert(header).second) {
          one();
          continue;
        }
      }
      const auto chunk = file->readChunk(known.offset, known.type);
      if (!chunk) return pass(chunk.error());
      auto copied = isUnknown(known.type) ? putUnknown(*chunk, into)
                    : known.type == kSlab ? copier.putSlab(*chunk, *slab++)
                                          : copier.put(*chunk);
      if (!copied) return copied;
      one();
    }
    return {};
  }

  std::vector<Part> parts_;
  std::vector<BodySummary> summaries_;
  std::vector<End> ends_;  // of the bodies
};

}  // namespace

Result<JoinReport> joinT4d(const std::vector<std::filesystem::path>& files,
                           const std::filesystem::path& into, const model::Progress& progress) {
  if (files.empty()) return invalid("no file is to be joined");
  // What share of the work reading through is; copying is the rest.
  constexpr double kReading = 0.5;
  Joiner joiner;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto reading = [&](double fraction) {
      if (!progress) return;
      progress(kReading * (static_cast<double>(i) + fraction) / static_cast<double>(files.size()));
    };
    const auto added =
        withinMemory(files[i].string(), [&] { return joiner.add(files[i], reading); });
    if (!added) return pass(added.error());
  }
  return withinMemory(into.string(), [&] {
    return joiner.write(into, [&](double fraction) {
      if (progress) progress(kReading + (1 - kReading) * fraction);
    });
  });
}

}  // namespace t4d::formats
