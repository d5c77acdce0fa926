#include "formats/t4d/joiner.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/t4d/metadata.h"
#include "formats/t4d/part_copier.h"
#include "formats/t4d/url.h"
#include "formats/t4d/within_memory.h"
#include "model/progress.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

Result<std::uint64_t> layerSize(const CopiedFile& part, std::uint64_t offset) {
  const auto file = ChunkFile::open(part.path);
  if (!file) return file.error();
  const auto chunk = file->readPartly(offset, kLayer);
  if (!chunk) return chunk.error();
  PayloadReader from(chunk->view());
  const auto front = takeLayerFront(from, part.head.features);
  if (!front) return front.error();
  return front->positions.rows;
}

}  // namespace

Result<std::vector<JoinedPart>> joinedParts(const std::vector<std::filesystem::path>& files) {
  std::vector<JoinedPart> parts;
  for (const std::filesystem::path& file : files) {
    if (!isManifest(file)) {
      parts.push_back({file, {}});
      continue;
    }
    const auto manifest = readManifest(file);
    if (!manifest) return manifest.error();
    for (const ManifestPart& part : manifest->parts) {
      if (auto open = openPart(part, shownName(file.string())); !open) return open.error();
      parts.push_back({part.place, part});
    }
  }
  if (parts.empty()) return invalid("no file is to be joined");
  return parts;
}

Result<void> Joiner::addAll(const std::vector<JoinedPart>& parts, const model::Progress& progress) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto added = withinMemory(parts[i].place.string(), [&] {
      return add(parts[i], model::eachOf(progress, i, parts.size()));
    });
    if (!added) return added;
  }
  return {};
}

Result<void> Joiner::add(const JoinedPart& part, const model::Progress& progress) {
  return take(part.described ? readIndexForCopy(part.place, chunks_)
                             : readForCopy(part.place, chunks_, progress));
}

Result<void> Joiner::addToName(const JoinedPart& part, const model::Progress& progress) {
  chunks_ = {};
  return add(part, progress);
}

Result<Joiner::JoinedHead> Joiner::head(std::vector<std::string>& losses) const {
  Metadata joined = metadata(losses);
  auto head = headOfCopy(joined, parts_);
  if (!head) return head.error();
  return JoinedHead{std::move(*head), std::move(joined)};
}

ManifestPart Joiner::described() const {
  ManifestPart part;
  part.chunks = parts_.back().sums;
  for (std::size_t i = 0; i < summaries_.size(); ++i) {
    part.bodies.push_back({parts_.back().bodies[i], seams_.back().vertices[i]});
  }
  return part;
}

Result<JoinReport> Joiner::write(const std::filesystem::path& into,
                                 const model::Progress& progress) const {
  std::vector<std::string> losses;
  auto out = beginCopy(into, metadata(losses), parts_);
  if (!out) return out.error();
  std::uint64_t done = 0;
  const auto one = [&] { return model::report(progress, ++done, chunks_.chunks.size()); };
  CopyState state;
  const auto posed = [](const CopiedFile& part) {
    const std::vector<std::string>& features = part.metadata().features;
    return std::ranges::find(features, kFeaturePose) != features.end();
  };
  PartCopier copier(*out, summaries_.size(), std::ranges::any_of(parts_, posed));
  const auto put = [&](ChunkFile::Chunk& chunk, const IndexRecord* slab) -> Result<void> {
    if (slab != nullptr) return copier.putSlab(chunk, *slab);
    if (!isUnknown(chunk.header.type)) return copier.put(chunk);
    const auto offset = out->putCopy(chunk.header, chunk.payload.bytes);
    return offset ? Result<void>() : offset.error();
  };
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto file = ChunkFile::open(parts_[i].path);
    if (!file) return file.error();
    copier.begin(parts_[i].path, *file, seams_[i].lowers);
    if (auto copied = copyChunks(*file, parts_[i], chunks_, put, state, one); !copied) {
      return copied.error();
    }
  }
  auto bytes = out->finish(summaries_);
  if (!bytes) return bytes.error();
  for (std::string& line : state.lost.lines()) losses.push_back(std::move(line));
  return JoinReport{summaries_, *bytes, std::move(losses), parts_.size()};
}

Result<void> Joiner::take(Result<CopiedFile> part) {
  if (!part) return part.error();
  if (!parts_.empty()) {
    if (auto fits = checkMetadata(*part); !fits) return fits;
  }
  const std::size_t bodies = part->bodies.size();
  summaries_.resize(bodies);
  ends_.resize(bodies);
  Seams seams{std::vector<std::uint64_t>(bodies), std::vector<std::uint64_t>(bodies)};
  std::vector<std::optional<IndexRecord>> last(bodies);
  for (const IndexRecord& record : part->slabs.of(chunks_.slabs)) {
    auto& before = last[record.parts.body];
    if (!before && !parts_.empty()) {
      if (auto fits = checkSeam(*part, record, seams); !fits) return fits;
    }
    before = record;
  }
  for (std::size_t i = 0; i < bodies; ++i) {
    if (last[i]) ends_[i] = {last[i]->time.end, headerAt(*part, last[i]->upper())};
    addSummary(i, part->bodies[i], seams.vertices[i]);
  }
  parts_.push_back(std::move(*part));
  seams_.push_back(std::move(seams));
  return {};
}

Metadata Joiner::metadata(std::vector<std::string>& losses) const {
  std::vector<const Metadata*> all;
  for (const CopiedFile& part : parts_) all.push_back(&part.metadata());
  return joinedMetadata(all, losses);
}

std::optional<ChunkHeader> Joiner::headerAt(const CopiedFile& part, std::uint64_t offset) const {
  if (offset == 0) return std::nullopt;
  const auto chunks = part.chunks.of(chunks_.chunks);
  ChunkHeader header = *std::ranges::lower_bound(chunks, offset, {}, &ChunkHeader::offset);
  header.offset = 0;
  return header;
}

Error Joiner::unfit(const CopiedFile& part, const std::string& message) const {
  return fail(ErrorCode::InvalidInput, message + " of " + parts_.front().path.string(),
              part.path.string());
}

Result<void> Joiner::checkMetadata(const CopiedFile& part) const {
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
  for (const CopiedFile& before : parts_) {
    if (const auto name = differingAttribute(before.metadata(), other)) {
      return unfit(part, fmt::format("cannot be joined: its attribute '{}' is not of the kind "
                                     "and the unit of that",
                                     *name));
    }
  }
  if (first.grid != other.grid) {
    return unfit(part, "cannot be joined: the grid of its positions is not that");
  }
  return {};
}

Result<void> Joiner::checkSeam(const CopiedFile& part, const IndexRecord& record,
                               Seams& seams) const {
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
    return wrong("does not begin with the layer, stored in the same way, with which it ends there");
  }
  if (lower) {
    const auto vertices = layerSize(part, record.lower());
    if (!vertices) return vertices.error();
    seams.lowers[record.parts.body] = record.lower();
    seams.vertices[record.parts.body] = *vertices;
  }
  return {};
}

void Joiner::addSummary(std::size_t body, const BodySummary& added, std::uint64_t shared) {
  if (added.slabs == 0) return;
  BodySummary& sum = summaries_[body];
  sum.time = {sum.slabs == 0 ? added.time.begin : sum.time.begin, added.time.end};
  sum.slabs += added.slabs;
  sum.vertices += added.vertices - shared;
  sum.tetrahedra += added.tetrahedra;
  if (added.vertices > 0) sum.bounds.add(added.bounds);
}

}  // namespace t4d::formats
