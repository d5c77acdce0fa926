#include "t4d/formats/t4d/reader.h"

#include <algorithm>
#include <array>
#include <tuple>

#include <fmt/format.h>

#include "t4d/formats/t4d/cell_limit.h"
#include "t4d/formats/t4d/chunk_counts.h"
#include "t4d/formats/t4d/chunk_file.h"
#include "t4d/formats/t4d/ending.h"
#include "t4d/formats/t4d/file_scan.h"
#include "t4d/formats/t4d/head_chunk.h"
#include "t4d/formats/t4d/index_chunk.h"
#include "t4d/formats/t4d/optional_chunks.h"
#include "t4d/formats/t4d/slab_source.h"
#include "t4d/formats/t4d/tally.h"
#include "t4d/formats/t4d/within_memory.h"
#include "t4d/model/sinks.h"

namespace t4d::formats {

using namespace t4d_layout;

static_assert(T4dReader::kMemoryPerFileByte == 12 * kMaxExpansion);

namespace {

/// File header and HEAD from their copies in the index, which saves a request. The end of the file
/// is then there to be read again.
Result<Beginning> readCopyOfBeginning(ChunkFile& file) {
  auto footer = file.readFooter();
  if (!footer) return pass(footer.error());
  file.plan(std::array{ByteRange{std::min(footer->done, file.size()), file.size()}});
  auto ending = readEnding(file, Features{});
  if (!ending) return pass(ending.error());
  Index& index = ending->index;
  const auto isHead = [&](const ChunkHeader& chunk) {
    return chunk.type == kHead && chunk.payloadBytes == index.head.size() &&
           payloadOf(chunk, std::as_bytes(std::span(index.head)));
  };
  if (index.chunks.empty() || !isHead(index.chunks.front())) {
    return file.damaged(ending->offset, "INDX: its copy of HEAD is different");
  }
  auto header = file.decodeHeader(index.fileHeader);
  if (!header) return pass(header.error());
  auto head = decodeHead(file, index.chunks.front(), std::move(index.head));
  if (!head) return pass(head.error());
  return Beginning{*header, std::move(*head)};
}

/// Without a sound index the front tells whether it is missing rightly, or the file is of another
/// format.
Result<Beginning> readRemoteBeginning(ChunkFile& file) {
  auto copy = readCopyOfBeginning(file);
  if (copy || copy.error().code == ErrorCode::Io) return copy;
  auto front = readBeginning(file);
  return !front && front.error().code == ErrorCode::Io ? copy : front;
}

/// Checks what the index says of the slabs against itself and DONE. Whether it is true is checked
/// when they are read.
Result<void> checkRecords(const ChunkFile& file, const Ending& ending, std::size_t bodyCount) {
  RecordChecker checker(file, bodyCount, ending.index.chunks);
  for (const IndexRecord& record : ending.index.slabs) {
    if (auto checked = checker.add(record); !checked) return checked;
  }
  if (auto checked = checkDone(ending.done, ending.index.slabs, bodyCount); !checked) {
    return file.damaged(ending.doneHeader.offset, "DONE: " + checked.error().message);
  }
  return {};
}

}  // namespace

class T4dReader::File {
 public:
  explicit File(ChunkFile file) : file_(std::move(file)), optional_(file_) {}

  Result<void> open(T4dOpen how, const model::Progress& progress,
                    std::optional<std::uint64_t> maxCells) {
    auto beginning =
        file_.remote() && how == T4dOpen::Whole ? readRemoteBeginning(file_) : readBeginning(file_);
    if (!beginning) return pass(beginning.error());
    const ChunkFile::Header* header = &beginning->header;
    const Head* head = &beginning->head;
    version_ = {header->major, header->minor};
    indexed_ = header->indexed;
    metadata_ = head->metadata;
    features_ = head->features;
    const std::size_t bodyCount = metadata_.bodies.size();
    Done done;
    std::vector<IndexRecord> records;
    if (indexed_ && how == T4dOpen::Whole) {
      auto ending = readEnding(file_, head->features);
      if (!ending && file_.remote()) return pass(ending.error());
      if (!ending) return cutOff(ending.error(), head->header.end());
      if (auto checked = checkEnding(file_, *ending, *header, *head); !checked) return checked;
      if (auto checked = checkRecords(file_, *ending, bodyCount); !checked) return checked;
      for (const ChunkHeader& chunk : ending->index.chunks) {
        addChunk(chunks_, chunk.type, chunk.bytes());
        optional_.add(chunk);
      }
      addChunk(chunks_, kIndex, file_.size() - kFooterBytes - ending->offset);
      records = std::move(ending->index.slabs);
      done = std::move(ending->done);
      doneOffset_ = ending->doneHeader.offset;
      file_.expectChunks(std::move(ending->index.chunks));
    } else {
      FileScan scan = scanFile(file_, head->header.end(), bodyCount, features_, progress);
      damage_ = std::move(scan.damage);
      if (!damage_) {
        auto tail = readTail(file_, *header, *head, scan);
        if (!tail) {
          damage_ = tail.error();
        } else if (how != T4dOpen::FromFront) {
          scan.slabs = std::move(*tail);  // the same, with what the index says of their contents
        }
      }
      addChunk(chunks_, kHead, head->header.bytes());
      for (const ChunkHeader& chunk : scan.chunks) {
        addChunk(chunks_, chunk.type, chunk.bytes());
        optional_.add(chunk);
      }
      if (scan.done) addChunk(chunks_, kDone, scan.end - scan.doneOffset);
      if (indexed_ && !damage_) addChunk(chunks_, kIndex, file_.size() - kFooterBytes - scan.end);
      file_.expectChunks(std::move(scan.chunks));
      records = std::move(scan.slabs);
      if (damage_ && how != T4dOpen::FromFront) return pass(*damage_);
      doneOffset_ = scan.doneOffset;
      done = scan.done ? std::move(*scan.done) : foundSoFar(records, bodyCount);
    }
    summaries_ = std::move(done.bodies);
    if (how != T4dOpen::FromFront) {
      if (auto checked = checkWork(maxCells); !checked) return checked;
    }
    bodies_.reserve(bodyCount);
    for (std::size_t i = 0; i < bodyCount; ++i) bodies_.emplace_back(file_, features_);
    for (const IndexRecord& record : records) bodies_[record.parts.body].add(record);
    return {};
  }

  ChunkFile file_;
  T4dVersion version_;
  bool indexed_ = false;
  Metadata metadata_;
  Features features_;
  std::vector<BodySummary> summaries_;
  std::uint64_t doneOffset_ = 0;
  std::vector<SlabSource> bodies_;
  std::optional<Error> damage_;
  std::vector<T4dChunks> chunks_;
  OptionalChunks optional_;

 private:
  Result<void> checkWork(std::optional<std::uint64_t> maxCells) const {
    std::uint64_t cells = 0;
    for (const BodySummary& body : summaries_) {
      cells = body.tetrahedra > kAnyCells - cells ? kAnyCells : cells + body.tetrahedra;
    }
    return checkCellCount(file_, cells, maxCells);
  }

  /// For a file whose header promises an index that is missing: adds how far it can be read.
  Result<void> cutOff(Error error, std::uint64_t firstChunk) {
    const FileScan scan = scanFile(file_, firstChunk, metadata_.bodies.size(), features_);
    if (scan.damage && !scan.done) {
      const std::size_t intact = scan.slabs.size();
      error.message += fmt::format("; {} intact {} before byte {}", intact,
                                   intact == 1 ? "slab comes" : "slabs come", scan.end);
    }
    return pass(std::move(error));
  }

  static Done foundSoFar(const std::vector<IndexRecord>& records, std::size_t bodyCount) {
    Done done;
    done.bodies.resize(bodyCount);
    for (const IndexRecord& record : records) {
      BodySummary& body = done.bodies[record.parts.body];
      if (body.slabs++ == 0) body.time.begin = record.time.begin;
      body.time.end = record.time.end;
    }
    return done;
  }
};

T4dReader::T4dReader(std::unique_ptr<File> file) : file_(std::move(file)) {}
T4dReader::T4dReader(T4dReader&&) noexcept = default;
T4dReader& T4dReader::operator=(T4dReader&&) noexcept = default;
T4dReader::~T4dReader() = default;

Result<T4dReader> T4dReader::open(const std::filesystem::path& pathOrUrl, T4dOpen how,
                                  const model::Progress& progress,
                                  std::optional<std::uint64_t> maxCells) {
  auto chunkFile = ChunkFile::open(pathOrUrl);
  if (!chunkFile) return pass(chunkFile.error());
  auto file = std::make_unique<File>(std::move(*chunkFile));
  const std::string name = file->file_.path();
  auto opened = withinMemory(name, [&] { return file->open(how, progress, maxCells); });
  if (!opened) return pass(opened.error());
  return T4dReader(std::move(file));
}

const Metadata& T4dReader::metadata() const { return file_->metadata_; }
T4dVersion T4dReader::version() const { return file_->version_; }
bool T4dReader::indexed() const { return file_->indexed_; }
std::uint64_t T4dReader::fileBytes() const { return file_->file_.size(); }
std::uint64_t T4dReader::bytesRead() const { return file_->file_.bytesRead(); }
std::uint64_t T4dReader::requests() const { return file_->file_.requests(); }
const std::string& T4dReader::name() const { return file_->file_.path(); }
const std::vector<T4dChunks>& T4dReader::chunks() const { return file_->chunks_; }
const OptionalChunks& T4dReader::optionalChunks() const { return file_->optional_; }
std::size_t T4dReader::bodyCount() const { return file_->bodies_.size(); }
const BodySummary& T4dReader::summary(std::size_t body) const { return file_->summaries_[body]; }
const model::Source& T4dReader::body(std::size_t index) const { return file_->bodies_[index]; }
std::uint64_t T4dReader::slabOffset(std::size_t body, std::size_t slab) const {
  return file_->bodies_[body].record(slab).slab;
}
Result<T4dSlab> T4dReader::slabContents(std::size_t body, std::size_t slab) const {
  const SlabSource& source = file_->bodies_[body];
  std::optional<SlabExtent> extent = source.record(slab).extent;
  if (!extent) {
    auto whole = source.slab(slab);
    if (!whole) return pass(whole.error());
    extent = extentOf(**whole);
  }
  return T4dSlab{source.timeSpan(slab), extent->cells, extent->bounds};
}
const std::optional<Error>& T4dReader::damage() const { return file_->damage_; }

Result<void> T4dReader::readThrough(std::size_t index, model::Sink& sink,
                                    const model::Progress& progress) const {
  Tally found;
  model::Tee both({&found, &sink});
  if (auto pumped = pump(body(index), both, progress); !pumped) return pumped;
  return checkSummaryOf(file_->file_, file_->doneOffset_, index, summary(index), found.sum);
}

Result<void> checkT4dFile(const std::filesystem::path& path, const model::Progress& progress) {
  model::NullSink nowhere;
  auto reader = T4dReader::open(path, T4dOpen::Checked, progress, kAnyCells);
  if (!reader) return pass(reader.error());
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    if (auto read = reader->readThrough(i, nowhere); !read) return read;
  }
  return {};
}

}  // namespace t4d::formats
