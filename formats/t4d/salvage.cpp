#include "formats/t4d/salvage.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/t4d/found_chunks.h"
#include "formats/t4d/head_chunk.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/manifest.h"
#include "formats/t4d/optional_chunks.h"
#include "formats/t4d/slab_source.h"
#include "formats/t4d/url.h"
#include "formats/t4d/within_memory.h"
#include "model/progress.h"
#include "t4d/file.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

/// Salvage reads all of a file, some of it more than once.
Result<ChunkFile> openLocal(const std::filesystem::path& path) {
  if (isManifest(path)) {
    return fail(ErrorCode::Unsupported,
                "is a file in parts: recover the parts that are damaged, and join them again",
                path.string());
  }
  if (schemeOf(path.string()).empty()) return ChunkFile::open(path);
  return fail(ErrorCode::Unsupported,
              "only a local file can be searched for what is intact: download it first",
              shownName(path.string()));
}

}  // namespace

class T4dSalvage::File {
 public:
  explicit File(ChunkFile file) : file_(std::move(file)), optional_(file_) {}

  /// If `judged`, a file that seems intact is also checked against all rules of the format. Without
  /// it, the file is known to be damaged.
  Result<void> run(bool judged, const model::Progress& progress) {
    constexpr double kWalkShare = 0.5;
    if (auto begun = readBeginning(); !begun) return begun;
    if (auto walked = walk(model::partOf(progress, 0, kWalkShare)); !walked) return walked;
    judgeEnd();
    found_.compareWith(index_.value_or(Index()));
    takeSlabs();
    if (judged && lost_.empty()) {
      auto checked = checkT4dFile(file_.path(), model::partOf(progress, kWalkShare, 1));
      if (!checked) {
        if (!checked.error().offset) return checked;
        lose(*checked.error().offset, checked.error().message);
      }
    }
    chooseBodies(!judged || !lost_.empty());
    if (chosen_.empty() && notT4d_ && !foundChunk_) return *notT4d_;
    std::stable_sort(lost_.begin(), lost_.end(),
                     [](const T4dLoss& a, const T4dLoss& b) { return a.offset < b.offset; });
    return {};
  }

  struct Body {
    SlabSource slabs;
    bool encloses = false;  ///< one of its slabs has cells and a duration
  };

  ChunkFile file_;
  Metadata metadata_;
  bool metadataSaved_ = false;
  std::map<std::uint32_t, Body> bodies_;
  std::vector<Body*> chosen_;  // those in metadata_.bodies
  std::optional<std::uint64_t> slabsKnown_;
  std::vector<T4dLoss> lost_;
  OptionalChunks optional_;

 private:
  void lose(std::uint64_t offset, std::string what,
            const std::optional<model::TimeSpan>& time = std::nullopt) {
    lost_.push_back({offset, std::move(what), time});
  }

  /// Reads the file header and HEAD. Fails if they are intact but unsupported.
  Result<void> readBeginning() {
    const auto header = file_.readHeader();
    if (header) {
      indexed_ = header->indexed;
    } else {
      if (header.error().code == ErrorCode::Unsupported) return header.error();
      notT4d_ = header.error();
      lose(header.error().offset.value_or(0), header.error().message);
    }
    auto head = readHead(file_);
    if (!head && head.error().code != ErrorCode::Unsupported &&
        !file_.readChunkHeader(kFileHeaderBytes)) {
      // Bytes may have been inserted before HEAD.
      const std::uint64_t next = nextChunk(kFileHeaderBytes);
      if (auto moved = readHead(file_, next)) {
        lose(kFileHeaderBytes, fmt::format("{}; HEAD is at byte {}", head.error().message, next));
        found_.addGap();
        head = std::move(moved);
      }
    }
    if (head) {
      metadata_ = std::move(head->metadata);
      features_ = head->features;
      metadataSaved_ = true;
      at_ = head->header.end();
      foundChunk_ = true;
      return {};
    }
    if (head.error().code == ErrorCode::Unsupported) return head.error();
    // Another chunk may be there instead.
    const auto chunk = file_.readChunkHeader(kFileHeaderBytes);
    if (chunk && chunk->type != kHead) {
      at_ = kFileHeaderBytes;
    } else {
      at_ = chunk ? chunk->end() : nextChunk(kFileHeaderBytes);
    }
    found_.addGap();
    lose(kFileHeaderBytes, fmt::format("{}; names of bodies, units and all else that HEAD says",
                                       head.error().message));
    return {};
  }

  /// The offset where the search continues when there is no chunk at `offset`.
  std::uint64_t nextChunk(std::uint64_t offset) {
    const auto next = file_.findChunk(offset + kAlignment);
    return next ? next->offset : file_.size();
  }

  Result<void> walk(const model::Progress& progress) {
    const auto footer = file_.readFooter();
    footerSaved_ = footer.has_value();
    if (!footer) footerError_ = footer.error();
    const std::uint64_t end = file_.size() - (footerSaved_ ? kFooterBytes : 0);
    while (at_ < end && !atEnd()) {
      if (auto on = model::report(progress, at_, file_.size()); !on) return on;
      const auto header = file_.readChunkHeader(at_);
      if (!header) {
        found_.addGap();
        const std::uint64_t next = std::min(nextChunk(at_), std::max(end, at_ + kAlignment));
        lose(at_, next < end ? fmt::format("{}; the next chunk is at byte {}",
                                           header.error().message, next)
                             : header.error().message);
        at_ = next;
        continue;
      }
      foundChunk_ = true;
      at_ = header->end();
      last_ = header->type;
      sawDone_ = sawDone_ || header->type == kDone;
      sawIndex_ = sawIndex_ || header->type == kIndex;
      if (const auto payload = file_.readPayload(*header)) {
        take(*header, payload->view);
      } else {
        found_.addGap();
        lose(header->offset, payload.error().message);
      }
    }
    return {};
  }

  /// Whether the previous chunk was the last of the file. Reports any bytes after the end, and an
  /// incomplete footer.
  bool atEnd() {
    const auto follows = [&](std::uint64_t end) {
      lose(end, fmt::format("{} bytes follow the end of the file", file_.size() - end));
      return true;
    };
    if (last_ == kDone && indexed_ == false) return follows(at_);
    if (last_ != kIndex || footerSaved_) return false;
    const std::uint64_t left = file_.size() - at_;
    if (left > kFooterBytes) {
      footerSaved_ = file_.readFooter(at_ + kFooterBytes).has_value();
      return footerSaved_ && follows(at_ + kFooterBytes);
    }
    if (left < kFooterBytes) {
      footerError_.message = fmt::format(
          "the file is truncated: {} of the {} bytes of its footer are left", left, kFooterBytes);
      footerError_.offset = at_;
    }
    return true;
  }

  void take(const ChunkHeader& header, const PayloadView& payload) {
    const auto wrong = [&](const std::string& message) {
      lose(header.offset, fmt::format("{}: {}", header.name(), message));
    };
    if (header.type == kConnectivity || header.type == kLayer || header.type == kPose) {
      found_.addPart(header);
    } else if (header.type == kSlab) {
      takeSlab(header, payload);
    } else if (header.type == kDone) {
      if (auto done = decodeDone(payload)) {
        done_ = std::move(*done);
        found_.addEnd();
      } else {
        wrong(done.error().message);
      }
    } else if (header.type == kIndex) {
      if (auto index = decodeIndex(payload)) {
        index_ = std::move(*index);
      } else {
        wrong(index.error().message);
      }
    } else if (header.type == kHead) {
      wrong("this chunk cannot be here");
    } else if (header.critical()) {
      wrong("a critical chunk of a type that this version does not know");
    } else {
      optional_.add(header);
    }
  }

  void takeSlab(const ChunkHeader& header, const PayloadView& payload) {
    auto decoded = decodeSlab(payload, features_);
    if (!decoded) return lose(header.offset, "SLAB: " + decoded.error().message);
    found_.addSlab({header.offset, header.bytes(), decoded->parts, decoded->time}, header.frontCrc);
  }

  /// Reads the slabs found, and lists the slabs of the index that are not intact.
  void takeSlabs() {
    std::map<std::uint64_t, std::size_t> lostAt;
    for (std::size_t i = 0; i < lost_.size(); ++i) lostAt.emplace(lost_[i].offset, i);
    for (const auto& slab : found_.slabs()) {
      if (auto taken = takeRecord(slab.record, slab.before); !taken) {
        lose(slab.record.slab, "SLAB: " + taken.error().message, slab.record.time);
      }
    }
    for (const auto& [record, before] : found_.missing()) {
      const auto known = lostAt.find(record.slab);
      if (known == lostAt.end() || lost_[known->second].time) {
        lose(record.slab, "SLAB: known from the index, not found whole", record.time);
      } else {
        lost_[known->second].time = record.time;
      }
    }
    if (index_) {
      slabsKnown_ = found_.slabs().size() + found_.missing().size();
    } else if (done_) {
      // Each slab takes some bytes: a larger number is wrong, and could overflow the sum.
      const std::uint64_t most = file_.size() / kChunkHeaderBytes;
      std::uint64_t known = 0;
      for (const BodySummary& body : done_->bodies) {
        if (body.slabs > most) return;
        known += body.slabs;
      }
      slabsKnown_ = std::max<std::uint64_t>(known, found_.slabs().size());
    }
  }

  /// Where the part is that originally was at `offset`, if it is whole.
  std::optional<std::uint64_t> placeOf(std::uint64_t offset) const {
    const auto now = found_.part(offset);
    return now && broken_.contains(*now) ? std::nullopt : now;
  }

  /// Takes the record of the slab that originally was at `before`; updates the distances of parts
  /// that have moved.
  Result<void> takeRecord(IndexRecord record, std::uint64_t before) {
    SlabParts& parts = record.parts;
    const std::uint64_t bodyCount = metadataSaved_ ? metadata_.bodies.size() : kMaxBodies;
    if (parts.body >= bodyCount) {
      return invalid(fmt::format("it belongs to body {}, of {}", parts.body, bodyCount));
    }
    const auto locate = [&](const char* part, std::uint64_t& distance) -> Result<void> {
      const auto now = placeOf(before - distance);
      if (!now) {
        return invalid(
            fmt::format("its {} at byte {} is missing or damaged", part, record.slab - distance));
      }
      distance = record.slab - *now;
      return {};
    };
    if (auto found = locate("CONN", parts.connectivity); !found) return found;
    for (std::uint64_t* layer : {&parts.lower, &parts.upper}) {
      if (*layer == 0) continue;
      if (auto found = locate("layer", *layer); !found) return found;
    }
    const auto found = bodies_.find(parts.body);
    if (found != bodies_.end()) {
      const SlabSource& slabs = found->second.slabs;
      const double end = slabs.record(slabs.slabCount() - 1).time.end;
      if (record.time.begin < end) {
        return invalid(fmt::format("it begins at time {}, the slab before ends at {}",
                                   record.time.begin, end));
      }
    }
    Body& body =
        found != bodies_.end()
            ? found->second
            : bodies_
                  .try_emplace(parts.body,
                               Body{SlabSource(file_, features_,
                                               [this](std::uint64_t pose, std::uint64_t distance) {
                                                 return placeOf(found_.before(pose) - distance);
                                               })})
                  .first->second;
    auto slab = body.slabs.read(record);
    if (!slab) {
      // Other slabs that refer to this part need not read it.
      const std::uint64_t at = slab.error().offset.value_or(0);
      broken_.insert(at);
      if (body.slabs.slabCount() == 0) bodies_.erase(parts.body);
      return invalid(at == record.slab ? slab.error().message
                                       : fmt::format("byte {}: {}", at, slab.error().message));
    }
    body.slabs.add(record);
    body.encloses = body.encloses ||
                    (record.time.begin < record.time.end && !(*slab)->connectivity->cells.empty());
    return {};
  }

  void judgeEnd() {
    std::vector<std::string> missing;
    if (!sawDone_) missing.emplace_back("end mark (DONE)");
    if (indexed_.value_or(footerSaved_ || sawIndex_)) {
      if (!sawIndex_) missing.emplace_back("index (INDX)");
      if (!footerSaved_ && sawIndex_) {
        lose(footerError_.offset.value_or(file_.size()), footerError_.message);
      } else if (!footerSaved_) {
        missing.emplace_back("footer");
      }
    }
    if (!missing.empty()) {
      lose(file_.size(), fmt::format("the file ends without {}", fmt::join(missing, ", ")));
    }
  }

  void chooseBodies(bool damaged) {
    const std::vector<BodyInfo> infos = std::exchange(metadata_.bodies, {});
    const auto nameOf = [&](std::uint32_t number) {
      return metadataSaved_ ? infos[number].name : fmt::format("body {}", number);
    };
    for (std::uint32_t i = 0; i < infos.size(); ++i) {
      if (bodies_.contains(i)) continue;
      lose(kFileHeaderBytes,
           fmt::format("the body '{}': none of its slabs is whole", infos[i].name));
    }
    for (auto& [number, body] : bodies_) {
      if (damaged && !body.encloses) {
        for (std::size_t i = 0; i < body.slabs.slabCount(); ++i) {
          const IndexRecord& slab = body.slabs.record(i);
          lose(slab.slab,
               fmt::format("the body '{}': what is whole of it encloses nothing", nameOf(number)),
               slab.time);
        }
        continue;
      }
      metadata_.bodies.push_back(metadataSaved_ ? infos[number] : BodyInfo{nameOf(number)});
      chosen_.push_back(&body);
    }
  }

  std::optional<bool> indexed_;  // according to the file header
  std::optional<Error> notT4d_;  // what is wrong with the file header
  Features features_;            // all of them, if HEAD does not say
  std::uint64_t at_ = 0;         // current offset of the scan
  bool foundChunk_ = false;
  bool sawDone_ = false;
  bool sawIndex_ = false;
  bool footerSaved_ = false;
  Error footerError_;
  ChunkType last_{};  // type of the previous chunk
  FoundChunks found_;
  std::set<std::uint64_t> broken_;  // parts with valid checksums that cannot be read
  std::optional<Done> done_;
  std::optional<Index> index_;
};

T4dSalvage::T4dSalvage(std::unique_ptr<File> file) : file_(std::move(file)) {}
T4dSalvage::T4dSalvage(T4dSalvage&&) noexcept = default;
T4dSalvage& T4dSalvage::operator=(T4dSalvage&&) noexcept = default;
T4dSalvage::~T4dSalvage() = default;

Result<T4dSalvage> T4dSalvage::open(const std::filesystem::path& path,
                                    const model::Progress& progress) {
  auto chunkFile = openLocal(path);
  if (!chunkFile) return chunkFile.error();
  auto file = std::make_unique<File>(std::move(*chunkFile));
  auto done = withinMemory(path.string(), [&] { return file->run(true, progress); });
  if (!done) return done.error();
  return T4dSalvage(std::move(file));
}

bool T4dSalvage::finds(const std::filesystem::path& path, std::uint64_t bytes) {
  auto chunkFile = openLocal(path);
  if (!chunkFile) return false;
  chunkFile->cutAfter(bytes);
  auto file = std::make_unique<File>(std::move(*chunkFile));
  const auto done = withinMemory(path.string(), [&] { return file->run(false, {}); });
  return done && !file->chosen_.empty();
}

const Metadata& T4dSalvage::metadata() const { return file_->metadata_; }
bool T4dSalvage::metadataSaved() const { return file_->metadataSaved_; }
const model::Source& T4dSalvage::body(std::size_t index) const {
  return file_->chosen_[index]->slabs;
}
std::uint64_t T4dSalvage::slabOffset(std::size_t body, std::size_t slab) const {
  return file_->chosen_[body]->slabs.record(slab).slab;
}
const OptionalChunks& T4dSalvage::optionalChunks() const { return file_->optional_; }
std::uint64_t T4dSalvage::slabsSaved() const {
  std::uint64_t saved = 0;
  for (const File::Body* body : file_->chosen_) saved += body->slabs.slabCount();
  return saved;
}
std::optional<std::uint64_t> T4dSalvage::slabsKnown() const { return file_->slabsKnown_; }
const std::vector<T4dLoss>& T4dSalvage::losses() const { return file_->lost_; }

}  // namespace t4d::formats
