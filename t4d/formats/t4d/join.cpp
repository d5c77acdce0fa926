#include "t4d/formats/t4d/join.h"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "t4d/formats/t4d/file_copy.h"
#include "t4d/formats/t4d/part_copier.h"
#include "t4d/formats/t4d/within_memory.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

/// What the next part of a body must continue.
struct End {
  double time = 0;
  std::optional<ChunkHeader> layer;  // of the upper layer of the last slab, its offset 0
};

class Joiner {
 public:
  /// Reads a part through, and checks that it continues those before.
  Result<void> add(const std::filesystem::path& path, const model::Progress& progress) {
    auto part = readForCopy(path, progress);
    if (!part) return pass(part.error());
    if (!parts_.empty()) {
      if (auto fits = checkMetadata(*part); !fits) return fits;
    }
    summaries_.resize(part->metadata().bodies.size());
    ends_.resize(summaries_.size());
    std::vector<std::uint64_t> lowers(summaries_.size());
    std::vector<bool> begun(summaries_.size());
    for (const IndexRecord& record : part->slabs) {
      const std::uint32_t body = record.parts.body;
      if (!begun[body]) {
        if (auto fits = checkSeam(*part, record); !fits) return fits;
        begun[body] = true;
        if (!parts_.empty()) lowers[body] = record.lower();
      }
      ends_[body] = {record.time.end, headerAt(*part, record.upper())};
    }
    for (std::size_t i = 0; i < summaries_.size(); ++i) addSummary(i, part->bodies[i]);
    parts_.push_back(std::move(*part));
    lowers_.push_back(std::move(lowers));
    return {};
  }

  Result<JoinReport> write(const std::filesystem::path& into, const model::Progress& progress) {
    std::uint64_t count = 0;
    std::vector<const Metadata*> all;
    for (const CopiedFile& part : parts_) {
      all.push_back(&part.metadata());
      count += part.chunks.size();
    }
    std::vector<std::string> losses;
    auto chunks = beginCopy(into, joinedMetadata(all, losses), parts_);
    if (!chunks) return pass(chunks.error());
    std::uint64_t done = 0;
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
      auto file = ChunkFile::open(parts_[i].path);
      if (!file) return pass(file.error());
      copier.begin(*file, lowers_[i]);
      const auto one = [&] {
        if (progress) progress(static_cast<double>(++done) / static_cast<double>(count));
      };
      if (auto copied = copyChunks(*file, parts_[i], put, state, one); !copied) {
        return pass(copied.error());
      }
    }
    auto bytes = chunks->finish(summaries_);
    if (!bytes) return pass(bytes.error());
    for (std::string& line : state.lost.lines()) losses.push_back(std::move(line));
    return JoinReport{summaries_, *bytes, std::move(losses)};
  }

 private:
  static std::optional<ChunkHeader> headerAt(const CopiedFile& part, std::uint64_t offset) {
    if (offset == 0) return std::nullopt;
    const auto found = std::ranges::lower_bound(part.chunks, offset, {}, &ChunkHeader::offset);
    ChunkHeader header = *found;
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
  Result<void> checkSeam(const CopiedFile& part, const IndexRecord& record) {
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

  void addSummary(std::size_t body, const BodySummary& added) {
    if (added.slabs == 0) return;
    BodySummary& sum = summaries_[body];
    sum.time = {sum.slabs == 0 ? added.time.begin : sum.time.begin, added.time.end};
    sum.slabs += added.slabs;
    sum.vertices += added.vertices;
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
  /// Of each part: of the bodies that continue, where their first layers are there; 0 for others.
  std::vector<std::vector<std::uint64_t>> lowers_;
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
