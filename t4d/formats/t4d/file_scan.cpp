#include "t4d/formats/t4d/file_scan.h"

#include <algorithm>
#include <array>
#include <iterator>

#include <fmt/format.h>

namespace t4d::formats {

using namespace t4d_layout;

FileScanner::FileScanner(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                         const Features& features)
    : file_(file),
      bodyCount_(bodyCount),
      features_(features),
      checker_(file, bodyCount, scan_.chunks) {
  scan_.end = firstChunk;
}

Result<ChunkHeader> FileScanner::next() {
  constexpr std::uint64_t kAhead = std::uint64_t{4} << 20;
  file_.plan(std::array{ByteRange{scan_.end, scan_.end + kAhead}});
  if (scan_.end == file_.size()) {
    return file_.damaged(scan_.end, "the file ends before its end mark: it is truncated");
  }
  auto header = file_.readChunkHeader(scan_.end);
  if (!header) return pass(header.error());
  auto payload = file_.readPayload(*header);
  if (!payload) return pass(payload.error());
  ++chunks_;
  if (auto taken = take(*header, payload->view); !taken) {
    if (!taken.error().where.empty()) return pass(taken.error());
    return file_.damaged(header->offset,
                         fmt::format("{}: {}", header->name(), taken.error().message),
                         taken.error().code);
  }
  if (header->type != kDone) scan_.chunks.push_back(*header);
  scan_.end = header->end();
  return header;
}

Result<void> FileScanner::take(const ChunkHeader& header, const PayloadView& payload) {
  if (header.type == kConnectivity || header.type == kLayer) {
    parts_.push_back({header.offset, header.type});
  } else if (header.type == kPose) {
    return takePose(header, payload);
  } else if (header.type == kSlab) {
    return takeSlab(header, payload);
  } else if (header.type == kDone) {
    auto done = decodeDone(payload);
    if (!done) return pass(done.error());
    // HEAD came before the first chunk of this scan, and this chunk does not count itself.
    if (done->chunks != chunks_) {
      return invalid(fmt::format("{} chunks come before it, not {}", chunks_, done->chunks));
    }
    if (auto checked = checkDone(*done, scan_.slabs, bodyCount_); !checked) return checked;
    if (auto checked = checkAllNamed(); !checked) return checked;
    scan_.doneOffset = header.offset;
    scan_.done = std::move(*done);
  } else if (header.type == kHead || header.type == kIndex) {
    return invalid("this chunk cannot be here");
  } else if (header.critical()) {
    return fail(ErrorCode::Unsupported,
                "a chunk of this type must be understood, and this version does not know it");
  }
  return {};
}

Result<void> FileScanner::takePose(const ChunkHeader& header, const PayloadView& payload) {
  const auto posed = decodePose(payload, features_);
  if (!posed) return pass(posed.error());
  const std::uint64_t layer = header.offset - posed->layer;
  if (!name(layer, {kLayer})) return invalid("it moves no LAYR that comes before it");
  const PartWindow& window = checker_.windowAt(header.offset);
  if (!window.has(kLayer, layer)) {
    return invalid(fmt::format("it moves none of the last {} LAYRs", window.size()));
  }
  parts_.push_back({header.offset, kPose, layer});
  return {};
}

Result<void> FileScanner::takeSlab(const ChunkHeader& header, const PayloadView& payload) {
  auto slab = decodeSlab(payload, features_);
  if (!slab) return pass(slab.error());
  const IndexRecord record = {header.offset, header.bytes(), slab->parts, slab->time};
  if (!name(record.connectivity(), {kConnectivity}) ||
      (slab->parts.lower != 0 && !name(record.lower(), {kLayer, kPose})) ||
      (slab->parts.upper != 0 && !name(record.upper(), {kLayer, kPose}))) {
    return invalid("it names a connectivity or a layer that does not come before it");
  }
  if (auto checked = checker_.add(record); !checked) return checked;
  scan_.slabs.push_back(record);
  return {};
}

std::vector<FileScanner::Part>::iterator FileScanner::find(std::uint64_t offset) {
  const auto found = std::ranges::lower_bound(parts_, offset, {}, &Part::offset);
  return found != parts_.end() && found->offset == offset ? found : parts_.end();
}

bool FileScanner::name(std::uint64_t offset, std::initializer_list<ChunkType> types) {
  const auto found = find(offset);
  if (found == parts_.end()) return false;
  if (std::ranges::find(types, found->type) == types.end()) return false;
  found->named = true;
  return true;
}

std::vector<std::uint64_t> FileScanner::neededParts() {
  std::vector<std::uint64_t> needed = checker_.windowAt(scan_.end).offsets();
  std::ranges::copy(checker_.lastUppers(), std::back_inserter(needed));
  for (std::size_t i = 0, count = needed.size(); i < count; ++i) {
    const auto part = find(needed[i]);
    if (part != parts_.end() && part->type == kPose) needed.push_back(part->layer);
  }
  std::ranges::sort(needed);
  return needed;
}

Result<void> FileScanner::checkAllNamed() const {
  const auto unused = std::ranges::find(parts_, false, &Part::named);
  if (unused == parts_.end()) return {};
  const std::string type(unused->type.begin(), unused->type.end());
  return file_.damaged(unused->offset, type + ": no slab names it");
}

FileScan scanFile(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                  const Features& features, const model::Progress& progress) {
  FileScanner scanner(file, firstChunk, bodyCount, features);
  std::optional<Error> damage;
  while (!scanner.done() && !damage) {
    if (const auto next = scanner.next(); !next) damage = next.error();
    if (progress) {
      progress(static_cast<double>(scanner.scan().end) / static_cast<double>(file.size()));
    }
  }
  FileScan scan = scanner.take();
  scan.damage = std::move(damage);
  return scan;
}

const PartWindow& RecordChecker::windowAt(std::uint64_t offset) {
  for (; next_ < chunks_.size() && chunks_[next_].offset < offset; ++next_) {
    window_.add(chunks_[next_].type, chunks_[next_].offset);
  }
  return window_;
}

std::vector<std::uint64_t> RecordChecker::lastUppers() const {
  std::vector<std::uint64_t> uppers;
  for (const auto& last : last_) {
    if (last && last->upper() != 0) uppers.push_back(last->upper());
  }
  return uppers;
}

bool RecordChecker::areCopies(std::uint64_t layer, std::uint64_t other) const {
  const auto headerAt = [&](std::uint64_t offset) {
    const auto found = std::ranges::lower_bound(chunks_, offset, {}, &ChunkHeader::offset);
    ChunkHeader header;
    if (found != chunks_.end() && found->offset == offset) header = *found;
    header.offset = 0;
    return header;
  };
  const ChunkHeader header = headerAt(layer);
  return header.type == kLayer && header == headerAt(other);
}

Result<void> RecordChecker::add(const IndexRecord& record) {
  const SlabParts& parts = record.parts;
  const auto wrong = [&](const std::string& message) {
    return file_.damaged(record.slab, "SLAB: " + message);
  };
  if (record.slab <= before_ || record.slab >= file_.size() ||
      record.slabBytes > file_.size() - record.slab) {
    return file_.damaged(record.slab,
                         "the index names a slab that is out of order or outside the file");
  }
  if (parts.connectivity >= record.slab || parts.lower >= record.slab ||
      parts.upper >= record.slab) {
    return wrong("it names a connectivity or a layer that does not come before it");
  }
  if (parts.body >= last_.size()) {
    return wrong(fmt::format("it belongs to body {}, of {}", parts.body, last_.size()));
  }
  std::optional<IndexRecord>& last = last_[parts.body];
  if (last) {
    if (record.lower() != last->upper() && !areCopies(record.lower(), last->upper())) {
      return wrong("its lower layer is not the upper layer of the slab before, nor a copy of it");
    }
    if (parts.lower != 0 ? record.time.begin != last->time.end
                         : record.time.begin < last->time.end) {
      return wrong(fmt::format("it begins at time {}, the slab before ends at {}",
                               record.time.begin, last->time.end));
    }
  }
  const PartWindow& window = windowAt(record.slab);
  const auto isNear = [&](std::uint64_t layer) {
    return layer == 0 || window.has(kLayer, layer) || window.has(kPose, layer);
  };
  const bool lowerIsKnown = last && record.lower() == last->upper();
  if (!window.has(kConnectivity, record.connectivity()) ||
      !(lowerIsKnown || isNear(record.lower())) || !isNear(record.upper())) {
    return wrong(
        fmt::format("its connectivity or a layer is none of the last {} before it", window.size()));
  }
  last = record;
  before_ = record.slab;
  return {};
}

Result<void> checkDone(const Done& done, const std::vector<IndexRecord>& records,
                       std::size_t bodyCount) {
  if (done.bodies.size() != bodyCount) {
    return invalid(fmt::format("it has {} bodies, the metadata {}", done.bodies.size(), bodyCount));
  }
  struct Found {
    std::uint64_t slabs = 0;
    model::TimeSpan time;
  };
  std::vector<Found> found(bodyCount);
  for (const IndexRecord& record : records) {
    Found& body = found[record.parts.body];
    if (body.slabs++ == 0) body.time.begin = record.time.begin;
    body.time.end = record.time.end;
  }
  for (std::size_t i = 0; i < bodyCount; ++i) {
    const BodySummary& said = done.bodies[i];
    if (found[i].slabs != said.slabs || found[i].time.begin != said.time.begin ||
        found[i].time.end != said.time.end) {
      return invalid(fmt::format(
          "body {} has {} slabs from time {} to {}; it says {} from {} to {}", i, found[i].slabs,
          found[i].time.begin, found[i].time.end, said.slabs, said.time.begin, said.time.end));
    }
  }
  return {};
}

}  // namespace t4d::formats
