#include <array>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "formats/t4d/cell_limit.h"
#include "formats/t4d/chunk_counts.h"
#include "formats/t4d/ending.h"
#include "formats/t4d/file_scan.h"
#include "formats/t4d/layout.h"
#include "formats/t4d/pipe_source.h"
#include "formats/t4d/slab_source.h"
#include "formats/t4d/t4d_formats.h"
#include "formats/t4d/tally.h"
#include "formats/t4d/within_memory.h"
#include "t4d/file.h"

namespace t4d::formats {

using namespace t4d_layout;

std::vector<platform::FileFormat> t4dFormats() {
  const std::vector<std::string_view> keeps = {"4D coordinates",   "tetrahedra", "orientation",
                                               "double precision", "bodies",     "names of bodies",
                                               "attributes",       "metadata",   "slabs"};
  return {{"t4d", {".t4d"}, keeps, true, "the signature", true, "t4d"},
          {"t4d in parts", {".t4dm"}, keeps, true}};
}

bool isPipe(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  return path == "-" || is_fifo(status) || is_character_file(status);
}

bool isT4d(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::binary);
  std::array<char, t4d_layout::kSignature.size()> begin{};
  file.read(begin.data(), begin.size());
  return std::memcmp(begin.data(), t4d_layout::kSignature.data(), begin.size()) == 0;
}

class T4dStream::File {
 public:
  File(std::unique_ptr<PipeSource> pipe, std::optional<std::uint64_t> maxCells)
      : maxCells_(maxCells), pipe_(pipe.get()), file_(std::move(pipe)) {}

  Result<void> open() {
    auto beginning = readBeginning(file_);
    if (!beginning) return beginning.error();
    header = beginning->header;
    head = std::move(beginning->head);
    const std::size_t bodyCount = head.metadata.bodies.size();
    addChunk(chunks, kHead, head.header.bytes());
    scanner_.emplace(file_, head.header.end(), bodyCount, head.features);
    tallies_.resize(bodyCount);
    for (std::size_t i = 0; i < bodyCount; ++i) bodies_.emplace_back(file_, head.features);
    return {};
  }

  Result<std::optional<Item>> next() {
    while (!scanner_->done()) {
      auto chunk = scanner_->next();
      if (!chunk) return chunk.error();
      addChunk(chunks, chunk->type, chunk->bytes());
      if (!chunk->critical()) forget();
      if (chunk->type != kSlab) continue;
      auto slab = readSlab();
      if (!slab) return slab.error();
      const IndexRecord record = scanner_->scan().slabs.back();
      return Item{record.parts.body, record.slab, std::move(*slab)};
    }
    if (auto ended = end(); !ended) return ended.error();
    return std::nullopt;
  }

  const std::string& name() const { return file_.path(); }
  std::uint64_t bytes() const { return file_.bytesRead(); }
  const BodySummary& summary(std::size_t body) const { return tallies_[body].sum; }

  ChunkFile::Header header;
  Head head;
  std::vector<T4dChunks> chunks;

 private:
  /// The slab that the scanner has come to.
  Result<std::shared_ptr<const model::Slab>> readSlab() {
    const IndexRecord record = scanner_->scan().slabs.back();
    const std::size_t body = record.parts.body;
    auto slab = bodies_[body].read(record);
    if (!slab) {
      Error error = slab.error();
      error.message = fmt::format("slab {}: {}", tallies_[body].sum.slabs, error.message);
      return error;
    }
    (void)tallies_[body].put(**slab);
    cells_ += (*slab)->connectivity->cells.size();
    if (auto checked = checkCellCount(file_.path(), file_.knownBytes(), cells_, maxCells_);
        !checked) {
      return checked.error();
    }
    if (header.indexed) extents_.push_back(extentOf(**slab));
    forget();
    return slab;
  }

  void forget() {
    std::vector<ByteRange> needed;
    for (const ChunkHeader& part : scanner_->neededParts()) {
      needed.push_back({part.offset, part.end()});
    }
    pipe_->forgetAllBut(needed);
  }

  /// Checks what follows DONE, and DONE against the slabs.
  Result<void> end() {
    if (ended_) return {};
    const FileScan& scan = scanner_->scan();
    std::uint64_t last = scan.end;
    if (header.indexed) {
      const auto index = file_.readChunkHeader(scan.end);
      if (!index) return index.error();
      if (auto read = file_.readPayload(*index); !read) return read.error();
      addChunk(chunks, index->type, index->bytes());
      last = index->end() + kFooterBytes;
      if (auto footer = file_.readFooter(last); !footer) return footer.error();
    }
    file_.plan({});
    if (file_.size() != last) {
      return file_.damaged(last, header.indexed ? "something follows the footer"
                                                : "something follows the end mark of a file "
                                                  "without index");
    }
    const auto slabs = readTail(file_, header, head, scan, false);
    if (!slabs) return slabs.error();
    for (std::size_t i = 0; i < extents_.size(); ++i) {
      if ((*slabs)[i].extent == extents_[i]) continue;
      return file_.damaged(scan.end,
                           fmt::format("INDX: record {} has other cells or bounds than the slab at "
                                       "byte {}",
                                       i, (*slabs)[i].slab));
    }
    for (std::size_t i = 0; i < tallies_.size(); ++i) {
      auto checked =
          checkSummaryOf(file_, scan.doneOffset, i, scan.done->bodies[i], tallies_[i].sum);
      if (!checked) return checked;
    }
    ended_ = true;
    return {};
  }

  std::optional<std::uint64_t> maxCells_;
  PipeSource* pipe_;
  ChunkFile file_;
  std::optional<FileScanner> scanner_;
  std::vector<SlabSource> bodies_;
  std::vector<Tally> tallies_;
  std::vector<SlabExtent> extents_;  // of all slabs, in the order of the file
  std::uint64_t cells_ = 0;
  bool ended_ = false;
};

T4dStream::T4dStream(std::unique_ptr<File> file) : file_(std::move(file)) {}
T4dStream::T4dStream(T4dStream&&) noexcept = default;
T4dStream& T4dStream::operator=(T4dStream&&) noexcept = default;
T4dStream::~T4dStream() = default;

Result<T4dStream> T4dStream::open(const std::filesystem::path& path,
                                  std::optional<std::uint64_t> maxCells) {
  auto pipe = PipeSource::open(path);
  if (!pipe) return pipe.error();
  auto file = std::make_unique<File>(std::move(*pipe), maxCells);
  auto opened = withinMemory(file->name(), [&] { return file->open(); });
  if (!opened) return opened.error();
  return T4dStream(std::move(file));
}

Result<std::optional<T4dStream::Item>> T4dStream::next() {
  return withinMemory(name(), [&] { return file_->next(); });
}

T4dVersion T4dStream::version() const { return {file_->header.major, file_->header.minor}; }
const Metadata& T4dStream::metadata() const { return file_->head.metadata; }
bool T4dStream::indexed() const { return file_->header.indexed; }
const std::string& T4dStream::name() const { return file_->name(); }
std::size_t T4dStream::bodyCount() const { return metadata().bodies.size(); }
std::uint64_t T4dStream::fileBytes() const { return file_->bytes(); }
const std::vector<T4dChunks>& T4dStream::chunks() const { return file_->chunks; }
const BodySummary& T4dStream::summary(std::size_t body) const { return file_->summary(body); }

}  // namespace t4d::formats
