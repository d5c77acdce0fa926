#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "formats/t4d/cell_limit.h"
#include "formats/t4d/chunk_counts.h"
#include "formats/t4d/chunk_file.h"
#include "formats/t4d/ending.h"
#include "formats/t4d/file_scan.h"
#include "formats/t4d/grouped_body.h"
#include "formats/t4d/head_chunk.h"
#include "formats/t4d/index_chunk.h"
#include "formats/t4d/manifest.h"
#include "formats/t4d/optional_chunks.h"
#include "formats/t4d/pages.h"
#include "formats/t4d/reader_file.h"
#include "formats/t4d/slab_source.h"
#include "formats/t4d/tally.h"
#include "formats/t4d/within_memory.h"
#include "model/progress.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::formats {

using namespace t4d_layout;

static_assert(T4dReader::kMemoryPerFileByte == 12 * kMaxExpansion);

namespace {

/// File header and HEAD from their copies in the index, which saves a request. The end of the file
/// is then there to be read again.
Result<Beginning> readCopyOfBeginning(ChunkFile& file) {
  auto footer = file.readFooter();
  if (!footer) return footer.error();
  file.plan(std::array{ByteRange{std::min(footer->done, file.size()), file.size()}});
  auto ending = readEnding(file, Features{});
  if (!ending) return ending.error();
  Index& index = ending->index;
  const auto isHead = [&](const ChunkHeader& chunk) {
    return chunk.type == kHead && chunk.payloadBytes == index.head.size() &&
           payloadOf(chunk, std::as_bytes(std::span(index.head)));
  };
  if (index.chunks.empty() || !isHead(index.chunks.front())) {
    return file.damaged(ending->offset, "INDX: its copy of HEAD is different");
  }
  auto header = file.decodeHeader(index.fileHeader);
  if (!header) return header.error();
  auto head = decodeHead(file, index.chunks.front(), std::move(index.head));
  if (!head) return head.error();
  return Beginning{*header, std::move(*head)};
}

/// Without a sound index the front tells whether it is missing rightly, or the file is of another
/// format.
Result<Beginning> orFront(ChunkFile& file, Result<Beginning> copy) {
  if (copy || copy.error().code == ErrorCode::Io) return copy;
  auto front = readBeginning(file);
  return !front && front.error().code == ErrorCode::Io ? copy : front;
}

/// What comes before the index in a file with pages, and what pages say.
struct PagedEnding {
  Beginning beginning;
  Done done;
  PageList pages;
};

/// DONE, PGIX, and the copies of file header and HEAD at the front of INDX; none if there are no
/// pages. Nothing else of INDX is read.
Result<std::optional<PagedEnding>> readPagedEnding(const ChunkFile& file,
                                                   const ChunkFile::Footer& footer) {
  const auto doneHeader = file.readChunkHeader(footer.done);
  if (!doneHeader || doneHeader->type != kDone || doneHeader->end() != footer.index) {
    return std::nullopt;
  }
  const auto chunk = file.readChunk(footer.done, kDone);
  if (!chunk) return chunk.error();
  auto done = decodeDone(chunk->payload.view);
  if (!done) return file.damaged(footer.done, "DONE: " + done.error().message);
  auto pages = readPageList(file, footer.done, done->bodies);
  if (!pages) return pages.error();
  if (!*pages) return std::nullopt;
  const auto index = file.readPartly(footer.index, kIndex);
  if (!index) return index.error();
  if (checksumOf(index->header()) != footer.indexChecksum) {
    return file.damaged(file.size() - kFooterBytes, "the footer is that of another index");
  }
  PayloadReader from(index->view());
  const auto fileHeader = from.takeBytes(kFileHeaderCopyBytes);
  from.take<std::uint32_t>();
  const auto packed = takePacked(from, {});
  if (!packed || packed->blocks.empty()) return file.damaged(footer.index, "INDX: it has no HEAD");
  std::string head;
  for (const auto& block : packed->blocks) {
    if (auto loaded = index->load(block); !loaded) return loaded.error();
    head.append(reinterpret_cast<const char*>(block.data()), block.size());
  }
  const ChunkHeader& known = (**pages).head;
  if (known.type != kHead || known.payloadBytes != head.size() ||
      !payloadOf(known, std::as_bytes(std::span(head)))) {
    return file.damaged(footer.index, "INDX: its copy of HEAD is different");
  }
  auto header = file.decodeHeader(fileHeader.first<kFileHeaderCopyBytes>());
  if (!header) return header.error();
  auto decoded = decodeHead(file, known, std::move(head));
  if (!decoded) return decoded.error();
  if (decoded->metadata.bodies.size() != done->bodies.size()) {
    return file.damaged(footer.done, "DONE: it has other bodies than HEAD");
  }
  return std::optional(
      PagedEnding{{*header, std::move(*decoded)}, std::move(*done), std::move(**pages)});
}

/// Where pages are looked for: an index that is smaller is read as fast.
constexpr std::uint64_t kSmallIndex = std::uint64_t{256} << 10;
/// The bytes fetched with DONE: PGIX before it, and the front of INDX.
constexpr std::uint64_t kListBytes = std::uint64_t{160} << 10;
constexpr std::uint64_t kFrontBytes = std::uint64_t{32} << 10;

/// Checks what the index says of the slabs against itself and DONE. Whether it is true is checked
/// when they are read.
Result<void> checkRecords(const ChunkFile& file, const Ending& ending, std::size_t bodyCount) {
  RecordChecker checker(file, bodyCount);
  std::vector<BodySpan> found(bodyCount);
  auto record = ending.index.slabs.begin();
  for (const ChunkHeader& chunk : ending.index.chunks) {
    if (chunk.type == kSlab) {
      if (auto checked = checker.add(*record); !checked) return checked;
      found[record->parts.body].add(record->time);
      ++record;
    }
    checker.addChunk(chunk);
  }
  if (auto checked = checkDone(ending.done, found); !checked) {
    return file.damaged(ending.doneHeader.offset, "DONE: " + checked.error().message);
  }
  return {};
}

/// One .t4d file.
class OneFile : public T4dReader::File {
 public:
  explicit OneFile(ChunkFile file) : file_(std::move(file)), optional_(file_) {}

  Result<void> open(T4dOpen how, const model::Progress& progress,
                    std::optional<std::uint64_t> maxCells) {
    if (how == T4dOpen::Whole && file_.size() > kSmallIndex) {
      const auto paged = openPages(maxCells);
      if (!paged) return paged.error();
      if (*paged) return {};
    }
    auto beginning = file_.remote() && how == T4dOpen::Whole
                         ? orFront(file_, readCopyOfBeginning(file_))
                         : readBeginning(file_);
    if (!beginning) return beginning.error();
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
      if (!ending && file_.remote()) return ending.error();
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
      if (damage_ && model::isStop(*damage_)) return *damage_;
      if (!damage_) {
        auto tail = readTail(file_, *header, *head, scan);
        if (!tail) {
          damage_ = tail.error();
        } else if (how != T4dOpen::FromFront) {
          const auto paged = openPages(maxCells);
          if (!paged) return paged.error();
          if (*paged) return {};
          scan.slabs = std::move(*tail);  // the same, with what the index says of their contents
        }
      }
      addChunk(chunks_, kHead, head->header.bytes());
      std::vector<ChunkHeader> chunks;
      for (const ChunkHeader& chunk : scan.chunks.all()) {
        addChunk(chunks_, chunk.type, chunk.bytes());
        optional_.add(chunk);
        chunks.push_back(chunk);
      }
      if (scan.done) addChunk(chunks_, kDone, scan.end - scan.doneOffset);
      if (indexed_ && !damage_) addChunk(chunks_, kIndex, file_.size() - kFooterBytes - scan.end);
      file_.expectChunks(std::move(chunks));
      for (const IndexRecord& record : scan.slabs.all()) records.push_back(record);
      if (damage_ && how != T4dOpen::FromFront) return *damage_;
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

  T4dVersion version() const override { return version_; }
  const Metadata& metadata() const override { return metadata_; }
  bool indexed() const override { return indexed_; }
  const std::string& name() const override { return file_.path(); }
  std::uint64_t fileBytes() const override { return file_.size(); }
  std::uint32_t fingerprint() const override {
    if (!indexed()) return 0;
    const auto footer = file_.readFooter();
    return footer ? footer->indexChecksum : 0;
  }
  std::uint64_t bytesRead() const override { return file_.bytesRead(); }
  std::uint64_t requests() const override { return file_.requests(); }
  const std::vector<T4dChunks>& chunks() const override { return chunks_; }
  const OptionalChunks& optionalChunks() const override { return optional_; }
  const BodySummary& summary(std::size_t body) const override { return summaries_[body]; }
  const model::Source& body(std::size_t index) const override {
    if (!paged_.empty()) return paged_[index];
    return bodies_[index];
  }
  std::uint64_t slabOffset(std::size_t body, std::size_t slab) const override {
    if (paged_.empty()) return bodies_[body].record(slab).slab;
    const auto place = openGroup(body, slab);
    return place ? place->first->record(place->second).slab : 0;
  }
  Result<T4dSlab> slabContents(std::size_t body, std::size_t slab) const override {
    if (!paged_.empty()) {
      const auto place = openGroup(body, slab);
      if (!place) return place.error();
      const auto& [source, number] = *place;
      const SlabExtent& extent = *source->record(number).extent;
      return T4dSlab{source->timeSpan(number), extent.cells, extent.bounds};
    }
    const SlabSource& source = bodies_[body];
    std::optional<SlabExtent> extent = source.record(slab).extent;
    if (!extent) {
      auto whole = source.slab(slab);
      if (!whole) return whole.error();
      extent = extentOf(**whole);
    }
    return T4dSlab{source.timeSpan(slab), extent->cells, extent->bounds};
  }
  const std::optional<Error>& damage() const override { return damage_; }
  Result<void> checkSummary(std::size_t body, const BodySummary& found) const override {
    return checkSummaryOf(file_, doneOffset_, body, summaries_[body], found);
  }

 private:
  /// The slabs of a page, by body.
  struct OpenPage {
    explicit OpenPage(ChunkFile view) : file(std::move(view)) {}
    ChunkFile file;
    std::map<std::uint32_t, SlabSource> bodies;
  };
  using SlabsOfPage = std::shared_ptr<const SlabSource>;

  /// Whether the file has pages, which are then all that is read of its index.
  Result<bool> openPages(std::optional<std::uint64_t> maxCells) {
    const auto read = file_.readFooter();
    if (!read) return false;
    const ChunkFile::Footer& footer = *read;
    // DONE, INDX and footer are after them.
    if (footer.done < kFileHeaderBytes || footer.done >= footer.index ||
        footer.index >= file_.size() || file_.size() - footer.done <= kSmallIndex) {
      return false;
    }
    const std::uint64_t begin = footer.done - std::min(footer.done, kListBytes);
    file_.plan(std::array{ByteRange{begin, std::min(file_.size(), footer.done + kFrontBytes)}});
    auto found = readPagedEnding(file_, footer);
    if (!found) return found.error();
    if (!*found) return false;
    PagedEnding& ending = **found;
    version_ = {ending.beginning.header.major, ending.beginning.header.minor};
    indexed_ = true;
    metadata_ = std::move(ending.beginning.head.metadata);
    features_ = ending.beginning.head.features;
    summaries_ = std::move(ending.done.bodies);
    doneOffset_ = footer.done;
    if (auto few = checkWork(maxCells); !few) return few.error();
    list_ = std::move(ending.pages);
    chunks_ = list_.chunks;
    addChunk(chunks_, kPageList, footer.done - list_.offset);
    addChunk(chunks_, kDone, footer.index - footer.done);
    addChunk(chunks_, kIndex, file_.size() - kFooterBytes - footer.index);
    for (std::uint32_t i = 0; i < metadata_.bodies.size(); ++i) addPagedBody(i);
    optional_ = OptionalChunks([this](const OptionalChunks::Take& take) { return walk(take); });
    return true;
  }

  void addPagedBody(std::uint32_t body) {
    std::vector<model::SlabGroup> groups;
    std::vector<std::size_t> numbers;  // of their pages
    for (std::size_t i = 0; i < list_.pages.size(); ++i) {
      const auto& bodies = list_.pages[i].bodies;
      const auto entry = std::ranges::find(bodies, body, &PageBody::body);
      if (entry == bodies.end()) continue;
      const std::size_t first = groups.empty() ? 0 : groups.back().end;
      groups.push_back({first, first + entry->slabs, entry->time, entry->bounds});
      numbers.push_back(i);
    }
    pageNumbers_.push_back(std::move(numbers));
    paged_.emplace_back(std::move(groups),
                        [this, body](std::size_t group) { return slabsOf(body, group); });
  }

  Result<SlabsOfPage> slabsOfPage(std::uint32_t body, std::size_t group) const {
    const auto page = pages_.get(pageNumbers_[body][group]);
    if (!page) return page.error();
    return SlabsOfPage(*page, &(*page)->bodies.at(body));
  }
  Result<std::shared_ptr<const model::Source>> slabsOf(std::uint32_t body,
                                                       std::size_t group) const {
    auto slabs = slabsOfPage(body, group);
    if (!slabs) return slabs.error();
    return std::shared_ptr<const model::Source>(std::move(*slabs));
  }
  Result<std::pair<SlabsOfPage, std::size_t>> openGroup(std::size_t body, std::size_t slab) const {
    const auto [group, number] = paged_[body].placeOf(slab);
    auto slabs = slabsOfPage(static_cast<std::uint32_t>(body), group);
    if (!slabs) return slabs.error();
    return std::pair(std::move(*slabs), number);
  }

  Result<std::shared_ptr<const OpenPage>> openPage(std::size_t number) const {
    auto page = withinMemory(name(), [&] { return readPage(file_, list_, number, features_); });
    if (!page) return page.error();
    auto open = std::make_shared<OpenPage>(file_.withChunks(std::move(page->chunks)));
    for (const IndexRecord& record : page->slabs) {
      auto found = open->bodies.find(record.parts.body);
      if (found == open->bodies.end()) {
        found = open->bodies.emplace(record.parts.body, SlabSource(open->file, features_)).first;
      }
      found->second.add(record);
    }
    return open;
  }

  /// The optional chunks, of which the pages have the headers.
  Result<void> walk(const OptionalChunks::Take& take) const {
    const auto isOptional = [](const T4dChunks& chunks) {
      ChunkType type{};
      std::ranges::copy(chunks.type, type.begin());
      return isUnknown(type);
    };
    if (std::ranges::none_of(chunks_, isOptional)) return {};
    std::uint64_t next = 0;  // chunks before it are known
    for (std::size_t i = 0; i < list_.pages.size(); ++i) {
      const auto page = readPage(file_, list_, i, features_);
      if (!page) return page.error();
      for (const ChunkHeader& chunk : page->chunks) {
        if (chunk.offset < next || !isUnknown(chunk.type)) continue;
        if (auto taken = take(file_, chunk); !taken) return taken;
      }
      next = page->chunks.back().end();
    }
    return {};
  }

  Result<void> checkWork(std::optional<std::uint64_t> maxCells) const {
    std::uint64_t cells = 0;
    for (const BodySummary& body : summaries_) {
      cells = body.tetrahedra > kAnyCells - cells ? kAnyCells : cells + body.tetrahedra;
    }
    return checkCellCount(file_.path(), file_.knownBytes(), cells, maxCells);
  }

  /// Adds to the error of a file whose header promises a missing index how far it can be read.
  Result<void> cutOff(Error error, std::uint64_t firstChunk) {
    const FileScan scan = scanFile(file_, firstChunk, metadata_.bodies.size(), features_);
    if (scan.damage && !scan.done) {
      const std::size_t intact = scan.slabs.size();
      error.message += fmt::format("; {} intact {} before byte {}", intact,
                                   intact == 1 ? "slab comes" : "slabs come", scan.end);
    }
    return error;
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

  ChunkFile file_;
  T4dVersion version_;
  bool indexed_ = false;
  Metadata metadata_;
  Features features_;
  std::vector<BodySummary> summaries_;
  std::uint64_t doneOffset_ = 0;
  std::vector<SlabSource> bodies_;  // unless it has pages
  PageList list_;
  std::vector<std::vector<std::size_t>> pageNumbers_;  // of the groups of each body
  std::deque<GroupedBody> paged_;
  OpenThings<OpenPage> pages_{[this](std::size_t number) { return openPage(number); }};
  std::optional<Error> damage_;
  std::vector<T4dChunks> chunks_;
  OptionalChunks optional_;
};

}  // namespace

Result<std::unique_ptr<T4dReader::File>> T4dReader::File::openOne(
    std::unique_ptr<ByteSource> source, T4dOpen how, const model::Progress& progress,
    std::optional<std::uint64_t> maxCells) {
  auto file = std::make_unique<OneFile>(ChunkFile(std::move(source)));
  const std::string name = file->name();
  auto opened = withinMemory(name, [&] { return file->open(how, progress, maxCells); });
  if (!opened) return opened.error();
  return file;
}

T4dReader::T4dReader(std::unique_ptr<File> file) : file_(std::move(file)) {}
T4dReader::T4dReader(T4dReader&&) noexcept = default;
T4dReader& T4dReader::operator=(T4dReader&&) noexcept = default;
T4dReader::~T4dReader() = default;

Result<T4dReader> T4dReader::open(const std::filesystem::path& pathOrUrl, T4dOpen how,
                                  const model::Progress& progress,
                                  std::optional<std::uint64_t> maxCells) {
  const auto open = [&]() -> Result<std::unique_ptr<File>> {
    if (isManifest(pathOrUrl)) return File::openParts(pathOrUrl, how, progress, maxCells);
    auto source = openByteSource(pathOrUrl);
    if (!source) return source.error();
    return File::openOne(std::move(*source), how, progress, maxCells);
  };
  auto file = open();
  if (!file) return file.error();
  return T4dReader(std::move(*file));
}

const Metadata& T4dReader::metadata() const { return file_->metadata(); }
T4dVersion T4dReader::version() const { return file_->version(); }
bool T4dReader::indexed() const { return file_->indexed(); }
std::uint64_t T4dReader::fileBytes() const { return file_->fileBytes(); }
std::uint32_t T4dReader::fingerprint() const { return file_->fingerprint(); }
std::uint64_t T4dReader::bytesRead() const { return file_->bytesRead(); }
std::uint64_t T4dReader::requests() const { return file_->requests(); }
const std::string& T4dReader::name() const { return file_->name(); }
const std::vector<T4dChunks>& T4dReader::chunks() const { return file_->chunks(); }
const OptionalChunks& T4dReader::optionalChunks() const { return file_->optionalChunks(); }
std::size_t T4dReader::bodyCount() const { return metadata().bodies.size(); }
const BodySummary& T4dReader::summary(std::size_t body) const { return file_->summary(body); }
const model::Source& T4dReader::body(std::size_t index) const { return file_->body(index); }
std::uint64_t T4dReader::slabOffset(std::size_t body, std::size_t slab) const {
  return file_->slabOffset(body, slab);
}
Result<T4dSlab> T4dReader::slabContents(std::size_t body, std::size_t slab) const {
  return file_->slabContents(body, slab);
}
const std::optional<Error>& T4dReader::damage() const { return file_->damage(); }

Result<void> T4dReader::readThrough(std::size_t index, model::Sink& sink,
                                    const model::Progress& progress) const {
  Tally found;
  model::Tee both({&found, &sink});
  if (auto pumped = pump(body(index), both, progress); !pumped) return pumped;
  return file_->checkSummary(index, found.sum);
}

Result<void> checkT4dFile(const std::filesystem::path& path, const model::Progress& progress) {
  model::NullSink nowhere;
  auto reader = T4dReader::open(path, T4dOpen::Checked, progress, kAnyCells);
  if (!reader) return reader.error();
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    if (auto read = reader->readThrough(i, nowhere); !read) return read;
  }
  return {};
}

}  // namespace t4d::formats
