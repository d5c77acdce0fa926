#include "t4d/formats/t4d/join.h"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "t4d/formats/t4d/file_copy.h"
#include "t4d/formats/t4d/manifest.h"
#include "t4d/formats/t4d/part_copier.h"
#include "t4d/formats/t4d/url.h"
#include "t4d/formats/t4d/within_memory.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

/// A file to be joined.
struct Given {
  std::filesystem::path place;
  /// If a manifest describes it: what that says.
  std::optional<ManifestPart> described;
};

/// What the next part of a body must continue.
struct End {
  double time = 0;
  std::optional<ChunkHeader> layer;  // of the upper layer of the last slab, its offset 0
};

/// What the bodies of a part continue: the layers with which they begin there.
struct Seams {
  std::vector<std::uint64_t> lowers;    // where they are, 0 for bodies that begin
  std::vector<std::uint64_t> vertices;  // how many they have
};

class Joiner {
 public:
  /// Reads a part through, and checks that it continues those before.
  Result<void> addToCopy(const std::filesystem::path& path, const model::Progress& progress) {
    return take(readForCopy(path, chunks_, progress));
  }

  /// The same of a part that will not be copied; of one that a manifest describes only its index is
  /// read.
  Result<void> addToName(const Given& part, const model::Progress& progress) {
    chunks_ = {};
    return take(part.described ? readIndexForCopy(part.place, chunks_)
                               : readForCopy(part.place, chunks_, progress));
  }

  /// HEAD of all of them, with its metadata.
  struct JoinedHead {
    CopyHead head;
    Metadata metadata;
  };
  Result<JoinedHead> head(std::vector<std::string>& losses) const {
    Metadata joined = metadata(losses);
    auto head = headOfCopy(joined, parts_);
    if (!head) return pass(head.error());
    return JoinedHead{std::move(*head), std::move(joined)};
  }

  /// The last part, as a manifest describes it; without its place, footer and digest.
  ManifestPart described() const {
    ManifestPart part;
    part.chunks = parts_.back().sums;
    for (std::size_t i = 0; i < summaries_.size(); ++i) {
      part.bodies.push_back({parts_.back().bodies[i], seams_.back().vertices[i]});
    }
    return part;
  }

  Result<JoinReport> write(const std::filesystem::path& into, const model::Progress& progress) {
    std::vector<std::string> losses;
    auto chunks = beginCopy(into, metadata(losses), parts_);
    if (!chunks) return pass(chunks.error());
    std::uint64_t done = 0;
    const auto one = [&] {
      if (!progress) return;
      progress(static_cast<double>(++done) / static_cast<double>(chunks_.chunks.size()));
    };
    CopyState state;
    const auto posed = [](const CopiedFile& part) {
      const std::vector<std::string>& features = part.metadata().features;
      return std::ranges::find(features, kFeaturePose) != features.end();
    };
    PartCopier copier(*chunks, summaries_.size(), std::ranges::any_of(parts_, posed));
    const auto put = [&](ChunkFile::Chunk& chunk, const IndexRecord* slab) -> Result<void> {
      if (slab != nullptr) return copier.putSlab(chunk, *slab);
      if (!isUnknown(chunk.header.type)) return copier.put(chunk);
      const auto offset = chunks->putCopy(chunk.header, chunk.payload.bytes);
      return offset ? Result<void>() : pass(offset.error());
    };
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const auto file = ChunkFile::open(parts_[i].path);
      if (!file) return pass(file.error());
      copier.begin(*file, seams_[i].lowers);
      if (auto copied = copyChunks(*file, parts_[i], chunks_, put, state, one); !copied) {
        return pass(copied.error());
      }
    }
    auto bytes = chunks->finish(summaries_);
    if (!bytes) return pass(bytes.error());
    for (std::string& line : state.lost.lines()) losses.push_back(std::move(line));
    return JoinReport{summaries_, *bytes, std::move(losses), parts_.size()};
  }

 private:
  Result<void> take(Result<CopiedFile> part) {
    if (!part) return pass(part.error());
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

  Metadata metadata(std::vector<std::string>& losses) const {
    std::vector<const Metadata*> all;
    for (const CopiedFile& part : parts_) all.push_back(&part.metadata());
    return joinedMetadata(all, losses);
  }

  std::optional<ChunkHeader> headerAt(const CopiedFile& part, std::uint64_t offset) const {
    if (offset == 0) return std::nullopt;
    const auto chunks = part.chunks.of(chunks_.chunks);
    ChunkHeader header = *std::ranges::lower_bound(chunks, offset, {}, &ChunkHeader::offset);
    header.offset = 0;
    return header;
  }

  tl::unexpected<Error> unfit(const CopiedFile& part, const std::string& message) const {
    return fail(ErrorCode::InvalidInput, message + " of " + parts_.front().path.string(),
                part.path.string());
  }

  Result<void> checkMetadata(const CopiedFile& part) const {
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

  /// `record` is the first of its body in `part`.
  Result<void> checkSeam(const CopiedFile& part, const IndexRecord& record, Seams& seams) const {
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
      const auto vertices = layerSize(part, record.lower());
      if (!vertices) return pass(vertices.error());
      seams.lowers[record.parts.body] = record.lower();
      seams.vertices[record.parts.body] = *vertices;
    }
    return {};
  }

  /// `shared`: vertices of the seam, which are in the part before, too.
  void addSummary(std::size_t body, const BodySummary& added, std::uint64_t shared) {
    if (added.slabs == 0) return;
    BodySummary& sum = summaries_[body];
    sum.time = {sum.slabs == 0 ? added.time.begin : sum.time.begin, added.time.end};
    sum.slabs += added.slabs;
    sum.vertices += added.vertices - shared;
    sum.tetrahedra += added.tetrahedra;
    if (added.vertices > 0) sum.bounds.add(added.bounds);
  }

  static Result<std::uint64_t> layerSize(const CopiedFile& part, std::uint64_t offset) {
    const auto file = ChunkFile::open(part.path);
    if (!file) return pass(file.error());
    const auto chunk = file->readPartly(offset, kLayer);
    if (!chunk) return pass(chunk.error());
    PayloadReader from(chunk->view());
    const auto front = takeLayerFront(from, part.head.features);
    if (!front) return pass(front.error());
    return front->positions.rows;
  }

  std::vector<CopiedFile> parts_;
  std::vector<Seams> seams_;  // of the parts
  CopiedChunks chunks_;       // of the parts that are copied, or of the last one
  std::vector<BodySummary> summaries_;
  std::vector<End> ends_;  // of the bodies
};

/// The files, with the parts of a manifest in its place; these are what it describes.
Result<std::vector<Given>> partsOf(const std::vector<std::filesystem::path>& files) {
  std::vector<Given> parts;
  for (const std::filesystem::path& file : files) {
    if (!isManifest(file)) {
      parts.push_back({file, {}});
      continue;
    }
    const auto manifest = readManifest(file);
    if (!manifest) return pass(manifest.error());
    for (const ManifestPart& part : manifest->parts) {
      if (auto open = openPart(part, shownName(file.native())); !open) return pass(open.error());
      parts.push_back({part.place, part});
    }
  }
  if (parts.empty()) return invalid("no file is to be joined");
  return parts;
}

/// The progress of one of `count` things that follow one another, of the share that all have.
model::Progress progressOf(const model::Progress& progress, std::size_t number, std::size_t count,
                           double share) {
  if (!progress) return {};
  return [=, &progress](double fraction) {
    progress(share * (static_cast<double>(number) + fraction) / static_cast<double>(count));
  };
}

/// Sets place, footer and digest.
Result<void> seal(ManifestPart& part, const std::filesystem::path& place,
                  const model::Progress& progress) {
  auto file = openByteSource(place);
  if (!file) return pass(file.error());
  auto footer = footerText(**file);
  if (!footer) return pass(footer.error());
  auto digest = sha256Of(**file, progress);
  if (!digest) return pass(digest.error());
  part.path = place.string();
  part.place = place;
  part.bytes = (*file)->size();
  part.sha256 = std::move(*digest);
  part.footer = std::move(*footer);
  return {};
}

/// What a manifest says of the parts, but for their paths in it.
Result<Manifest> describe(const std::vector<Given>& parts, const model::Progress& progress) {
  constexpr double kReading = 0.7;  // the rest is the digest
  Joiner joiner;
  Manifest manifest;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto share = [&](double from, double to) -> model::Progress {
      if (!progress) return {};
      return [=, &progress, count = parts.size()](double fraction) {
        const double within = from + (to - from) * fraction;
        progress((static_cast<double>(i) + within) / static_cast<double>(count));
      };
    };
    const Given& given = parts[i];
    const auto added = withinMemory(given.place.string(),
                                    [&] { return joiner.addToName(given, share(0, kReading)); });
    if (!added) return pass(added.error());
    ManifestPart part = joiner.described();
    if (given.described) {
      part = {given.described->path,   given.place,
              given.described->bytes,  given.described->sha256,
              given.described->footer, given.described->chunks,
              std::move(part.bodies)};
    } else if (auto sealed = seal(part, given.place, share(kReading, 1)); !sealed) {
      return pass(sealed.error());
    }
    manifest.parts.push_back(std::move(part));
  }
  std::vector<std::string> losses;
  auto head = joiner.head(losses);
  if (!head) return pass(head.error());
  manifest.head = std::move(head->head.text);
  manifest.metadata = std::move(head->metadata);
  manifest.losses = std::move(losses);
  return manifest;
}

}  // namespace

Result<JoinReport> joinT4d(const std::vector<std::filesystem::path>& files,
                           const std::filesystem::path& into, const model::Progress& progress) {
  const auto parts = partsOf(files);
  if (!parts) return pass(parts.error());
  // What share of the work reading through is; copying is the rest.
  constexpr double kReading = 0.5;
  Joiner joiner;
  for (std::size_t i = 0; i < parts->size(); ++i) {
    const std::filesystem::path& place = (*parts)[i].place;
    const auto added = withinMemory(place.string(), [&] {
      return joiner.addToCopy(place, progressOf(progress, i, parts->size(), kReading));
    });
    if (!added) return pass(added.error());
  }
  return withinMemory(into.string(), [&] {
    return joiner.write(into, [&](double fraction) {
      if (progress) progress(kReading + (1 - kReading) * fraction);
    });
  });
}

Result<Manifest> describeParts(const std::vector<std::filesystem::path>& files,
                               const model::Progress& progress) {
  const auto parts = partsOf(files);
  if (!parts) return pass(parts.error());
  return describe(*parts, progress);
}

Result<JoinReport> writeManifest(const std::vector<std::filesystem::path>& files,
                                 const std::filesystem::path& into,
                                 const model::Progress& progress) {
  const auto parts = partsOf(files);
  if (!parts) return pass(parts.error());
  std::vector<std::string> paths;
  for (const Given& part : *parts) {
    auto path = pathInManifest(part.place, into);
    if (!path) return pass(path.error());
    paths.push_back(std::move(*path));
  }
  auto manifest = describe(*parts, progress);
  if (!manifest) return pass(manifest.error());
  for (std::size_t i = 0; i < paths.size(); ++i) manifest->parts[i].path = std::move(paths[i]);
  const std::string text = manifestText(*manifest);
  auto out = OutputFile::create(into);
  if (!out) return pass(out.error());
  if (auto written = out->write(text.data(), text.size()); !written) return pass(written.error());
  if (auto done = out->commit(); !done) return pass(done.error());
  JoinReport report{{}, text.size(), std::move(manifest->losses), parts->size()};
  for (std::size_t i = 0; i < manifest->metadata.bodies.size(); ++i) {
    report.bodies.push_back(manifest->summary(i));
  }
  return report;
}

}  // namespace t4d::formats
