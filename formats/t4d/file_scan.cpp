#include "formats/t4d/file_scan.h"

#include <algorithm>
#include <array>
#include <iterator>

#include <fmt/format.h>

#include "model/progress.h"

namespace t4d::formats {

using namespace t4d_layout;

FileScanner::FileScanner(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                         const Features& features)
    : file_(file), features_(features), checker_(file, bodyCount), found_(bodyCount) {
  scan_.end = firstChunk;
}

Result<ChunkHeader> FileScanner::next() {
  constexpr std::uint64_t kAhead = std::uint64_t{4} << 20;
  file_.plan(std::array{ByteRange{scan_.end, scan_.end + kAhead}});
  if (scan_.end == file_.size()) {
    return file_.damaged(scan_.end, "the file ends before its end mark: it is truncated");
  }
  auto header = file_.readChunkHeader(scan_.end);
  if (!header) return header.error();
  auto payload = file_.readPayload(*header);
  if (!payload) return payload.error();
  ++chunks_;
  if (auto taken = take(*header, payload->view); !taken) {
    if (!taken.error().where.empty()) return taken.error();
    return file_.damaged(header->offset,
                         fmt::format("{}: {}", header->name(), taken.error().message),
                         taken.error().code);
  }
  if (header->type != kDone) scan_.chunks.push_back(*header);
  checker_.addChunk(*header);
  scan_.end = header->end();
  return header;
}

Result<void> FileScanner::take(const ChunkHeader& header, const PayloadView& payload) {
  if (header.type == kConnectivity || header.type == kLayer) {
    parts_.push_back({header});
  } else if (header.type == kPose) {
    return takePose(header, payload);
  } else if (header.type == kSlab) {
    return takeSlab(header, payload);
  } else if (header.type == kDone) {
    auto done = decodeDone(payload);
    if (!done) return done.error();
    // HEAD came before the first chunk of this scan, and this chunk does not count itself.
    if (done->chunks != chunks_) {
      return invalid(fmt::format("{} chunks come before it, not {}", chunks_, done->chunks));
    }
    if (auto checked = checkDone(*done, found_); !checked) return checked;
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
  if (!posed) return posed.error();
  const std::uint64_t layer = header.offset - posed->layer;
  if (!name(layer, {kLayer})) return invalid("it moves no LAYR that comes before it");
  const PartWindow& window = checker_.window();
  if (window.find(kLayer, layer) == nullptr) {
    return invalid(fmt::format("it moves none of the last {} LAYRs", window.size()));
  }
  parts_.push_back({header, layer});
  return {};
}

Result<void> FileScanner::takeSlab(const ChunkHeader& header, const PayloadView& payload) {
  auto slab = decodeSlab(payload, features_);
  if (!slab) return slab.error();
  const IndexRecord record = {header.offset, header.bytes(), slab->parts, slab->time};
  if (!name(record.connectivity(), {kConnectivity}) ||
      (slab->parts.lower != 0 && !name(record.lower(), {kLayer, kPose})) ||
      (slab->parts.upper != 0 && !name(record.upper(), {kLayer, kPose}))) {
    return invalid("it names a connectivity or a layer that does not come before it");
  }
  if (auto checked = checker_.add(record); !checked) return checked;
  scan_.slabs.push_back(record);
  found_[record.parts.body].add(record.time);
  if (parts_.size() >= forgetAt_) forgetParts();
  return {};
}

const FileScanner::Part* FileScanner::find(std::uint64_t offset) const {
  const auto offsetOf = [](const Part& part) { return part.header.offset; };
  const auto found = std::ranges::lower_bound(parts_, offset, {}, offsetOf);
  return found != parts_.end() && offsetOf(*found) == offset ? &*found : nullptr;
}

bool FileScanner::name(std::uint64_t offset, std::initializer_list<ChunkType> types) {
  const Part* found = find(offset);
  if (found == nullptr) return false;
  if (std::ranges::find(types, found->header.type) == types.end()) return false;
  parts_[static_cast<std::size_t>(found - parts_.data())].named = true;
  return true;
}

std::vector<ChunkHeader> FileScanner::neededParts() const {
  std::vector<ChunkHeader> needed = checker_.window().chunks();
  std::ranges::copy(checker_.lastUppers(), std::back_inserter(needed));
  for (std::size_t i = 0, count = needed.size(); i < count; ++i) {
    if (needed[i].type != kPose) continue;
    const Part* pose = find(needed[i].offset);
    const Part* layer = pose == nullptr ? nullptr : find(pose->layer);
    if (layer != nullptr) needed.push_back(layer->header);
  }
  std::ranges::sort(needed, {}, &ChunkHeader::offset);
  return needed;
}

/// Forgets parts that are named, and that slabs to come do not need.
void FileScanner::forgetParts() {
  const std::vector<ChunkHeader> needed = neededParts();
  std::erase_if(parts_, [&](const Part& part) {
    return part.named &&
           !std::ranges::binary_search(needed, part.header.offset, {}, &ChunkHeader::offset);
  });
  forgetAt_ = 2 * parts_.size() + 1024;
}

Result<void> FileScanner::checkAllNamed() const {
  const auto unused = std::ranges::find(parts_, false, &Part::named);
  if (unused == parts_.end()) return {};
  return file_.damaged(unused->header.offset, unused->header.name() + ": no slab names it");
}

FileScan scanFile(const ChunkFile& file, std::uint64_t firstChunk, std::size_t bodyCount,
                  const Features& features, const model::Progress& progress) {
  FileScanner scanner(file, firstChunk, bodyCount, features);
  std::optional<Error> damage;
  while (!scanner.done() && !damage) {
    if (const auto next = scanner.next(); !next) damage = next.error();
    if (auto on = model::report(progress, scanner.scan().end, file.size()); !on) {
      damage = on.error();
    }
  }
  FileScan scan = scanner.take();
  scan.damage = std::move(damage);
  return scan;
}

std::vector<ChunkHeader> RecordChecker::lastUppers() const {
  std::vector<ChunkHeader> uppers;
  for (const auto& last : last_) {
    if (last && last->record.upper() != 0) uppers.push_back(last->upper);
  }
  return uppers;
}

bool RecordChecker::isCopy(std::uint64_t layer, const ChunkHeader& of) const {
  const ChunkHeader* found = window_.find(kLayer, layer);
  if (found == nullptr) return false;
  ChunkHeader copy = *found;
  copy.offset = of.offset;
  return copy == of;
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
  std::optional<Last>& last = last_[parts.body];
  const bool continues = last && record.lower() == last->record.upper();
  const bool lowerIsKnown =
      parts.lower == 0 || continues || window_.findLayer(record.lower()) != nullptr;
  if (last) {
    if (lowerIsKnown && !continues && !isCopy(record.lower(), last->upper)) {
      return wrong("its lower layer is not the upper layer of the slab before, nor a copy of it");
    }
    const double end = last->record.time.end;
    if (parts.lower != 0 ? record.time.begin != end : record.time.begin < end) {
      return wrong(
          fmt::format("it begins at time {}, the slab before ends at {}", record.time.begin, end));
    }
  }
  const ChunkHeader* upper = window_.findLayer(record.upper());
  if (window_.find(kConnectivity, record.connectivity()) == nullptr || !lowerIsKnown ||
      !(parts.upper == 0 || upper != nullptr)) {
    return wrong(fmt::format("its connectivity or a layer is none of the last {} before it",
                             window_.size()));
  }
  last = {record, upper == nullptr ? ChunkHeader() : *upper};
  before_ = record.slab;
  return {};
}

Result<void> checkDone(const Done& done, const std::vector<BodySpan>& found) {
  if (done.bodies.size() != found.size()) {
    return invalid(
        fmt::format("it has {} bodies, the metadata {}", done.bodies.size(), found.size()));
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
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
