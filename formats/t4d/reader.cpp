#include "formats/t4d/reader.h"

#include <algorithm>
#include <new>
#include <type_traits>

#include <fmt/format.h>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/file_scan.h"

namespace t4d::formats {

using namespace t4d_layout;
using model::Connectivity;
using model::Slab;

namespace {

/// HEAD, the first chunk.
struct Head {
  Metadata metadata;
  Features features;
  std::uint64_t end = 0;
};

Result<Head> readHead(ChunkFile& file) {
  auto header = file.readChunkHeader(kFileHeaderBytes);
  if (!header) return pass(header.error());
  if (header->type != kHead) {
    return file.damaged(header->offset, "the first chunk is not HEAD");
  }
  if (header->payloadBytes > kMaxHeadBytes) {
    return file.damaged(header->offset, fmt::format("HEAD has {} bytes; at most {} are allowed",
                                                    header->payloadBytes, kMaxHeadBytes));
  }
  auto payload = file.readPayload(*header);
  if (!payload) return pass(payload.error());
  auto metadata = parseHead({reinterpret_cast<const char*>(payload->data()), payload->size()});
  if (!metadata) {
    return file.damaged(header->offset, metadata.error().message, metadata.error().code);
  }
  const auto named = [&](std::string_view feature) {
    const auto& all = metadata->features;
    return std::find(all.begin(), all.end(), feature) != all.end();
  };
  const Features features = {named(kFeatureZstd), named(kFeatureMeans)};
  return Head{std::move(*metadata), features, header->end()};
}

/// The end of a file with an index.
struct Index {
  std::vector<IndexRecord> records;
  Done done;
  std::uint64_t doneOffset = 0;
};

Result<Index> readIndex(ChunkFile& file) {
  auto footer = file.readFooter();
  if (!footer) return pass(footer.error());
  auto done = file.readChunk(footer->done, kDone);
  if (!done) return pass(done.error());
  auto index = file.readChunk(footer->index, kIndex);
  if (!index) return pass(index.error());
  if (done->header.end() != footer->index || index->header.end() != file.size() - kFooterBytes) {
    return file.damaged(footer->done, "end mark, index and footer do not follow one another");
  }
  auto decodedDone = decodeDone(done->payload);
  if (!decodedDone) return file.damaged(footer->done, "DONE: " + decodedDone.error().message);
  auto records = decodeIndex(index->payload);
  if (!records) return file.damaged(footer->index, "INDX: " + records.error().message);
  return Index{std::move(*records), std::move(*decodedDone), footer->done};
}

/// Judges the index by itself: whether the slabs are where it says is seen when they are read.
Result<void> checkIndex(const ChunkFile& file, const Index& index, std::size_t bodyCount) {
  RecordJudge judge(file, bodyCount);
  for (const IndexRecord& record : index.records) {
    if (auto judged = judge.add(record); !judged) return judged;
  }
  if (auto checked = checkDone(index.done, index.records, bodyCount); !checked) {
    return file.damaged(index.doneOffset, "DONE: " + checked.error().message);
  }
  return {};
}

/// After the end mark that `scan` found come an index that says the same and a footer, or nothing.
Result<void> checkTail(ChunkFile& file, bool indexed, const FileScan& scan) {
  if (!indexed) {
    if (scan.end == file.size()) return {};
    return file.damaged(scan.end,
                        fmt::format("{} bytes follow the end mark of a file without index",
                                    file.size() - scan.end));
  }
  auto index = readIndex(file);
  if (!index) return pass(index.error());
  if (index->doneOffset != scan.doneOffset || index->records != scan.slabs) {
    return file.damaged(scan.end, "the index does not say where the slabs are");
  }
  return {};
}

/// A file may honestly hold more than fits into memory.
template <class Function>
std::invoke_result_t<Function> withinMemory(const std::string& where, Function&& function) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "what it holds does not fit into memory", where);
  }
}

}  // namespace

class T4dReader::File {
 public:
  explicit File(ChunkFile file) : file_(std::move(file)) {}

  Result<void> open(T4dOpen how, const model::Progress& progress) {
    auto header = file_.readHeader();
    if (!header) return pass(header.error());
    version_ = {header->major, header->minor};
    indexed_ = header->indexed;
    auto head = readHead(file_);
    if (!head) return pass(head.error());
    metadata_ = std::move(head->metadata);
    features_ = head->features;
    const std::size_t bodyCount = metadata_.bodies.size();
    Done done;
    if (indexed_ && how == T4dOpen::Whole) {
      auto index = readIndex(file_);
      if (!index) return cutOff(index.error(), head->end);
      if (auto checked = checkIndex(file_, *index, bodyCount); !checked) return checked;
      records_ = std::move(index->records);
      done = std::move(index->done);
      doneOffset_ = index->doneOffset;
    } else {
      FileScan scan = scanFile(file_, head->end, bodyCount, features_, progress);
      damage_ = std::move(scan.damage);
      if (!damage_) {
        if (auto tail = checkTail(file_, indexed_, scan); !tail) damage_ = tail.error();
      }
      if (damage_ && how != T4dOpen::FromFront) return pass(*damage_);
      records_ = std::move(scan.slabs);
      doneOffset_ = scan.doneOffset;
      done = scan.done ? std::move(*scan.done) : foundSoFar(bodyCount);
    }
    summaries_ = std::move(done.bodies);
    bodies_.reserve(bodyCount);
    for (std::size_t i = 0; i < bodyCount; ++i) bodies_.emplace_back(*this);
    for (std::size_t i = 0; i < records_.size(); ++i) bodies_[records_[i].parts.body].add(i);
    return {};
  }

  class Body : public model::Source {
   public:
    explicit Body(File& file) : file_(file) {}
    void add(std::size_t record) { slabs_.push_back(record); }

    std::size_t slabCount() const override { return slabs_.size(); }
    model::TimeSpan timeSpan(std::size_t index) const override { return record(index).time; }
    Result<const Slab*> slab(std::size_t index) override {
      auto read = withinMemory(file_.file_.path(), [&] { return readSlab(record(index)); });
      if (!read) {
        Error error = read.error();
        error.message = fmt::format("slab {}: {}", index, error.message);
        return pass(std::move(error));
      }
      return &slab_;
    }
    const IndexRecord& record(std::size_t index) const { return file_.records_[slabs_[index]]; }

   private:
    Result<void> readSlab(const IndexRecord& record);
    Result<void> readConnectivity(std::uint64_t offset);
    Result<Layer> readLayer(std::uint64_t offset);

    File& file_;
    std::vector<std::size_t> slabs_;  // records of this body
    Slab slab_;
    std::uint64_t connectivityOffset_ = 0;
    std::uint64_t upperOffset_ = 0;  // the layer that `upper_` is
    Layer upper_;
  };

  ChunkFile file_;
  T4dVersion version_;
  bool indexed_ = false;
  Metadata metadata_;
  Features features_;
  std::vector<IndexRecord> records_;
  std::vector<BodySummary> summaries_;
  std::uint64_t doneOffset_ = 0;
  std::vector<Body> bodies_;
  std::optional<Error> damage_;

 private:
  /// A file that promises an index and does not end with one: says how far it can be read.
  Result<void> cutOff(Error error, std::uint64_t firstChunk) {
    const FileScan scan = scanFile(file_, firstChunk, metadata_.bodies.size(), features_);
    if (scan.damage && !scan.done) {
      error.message +=
          fmt::format("; {} whole slabs come before byte {}", scan.slabs.size(), scan.end);
    }
    return pass(std::move(error));
  }

  Done foundSoFar(std::size_t bodyCount) const {
    Done done;
    done.bodies.resize(bodyCount);
    for (const IndexRecord& record : records_) {
      BodySummary& body = done.bodies[record.parts.body];
      if (body.slabs++ == 0) body.time.begin = record.time.begin;
      body.time.end = record.time.end;
    }
    return done;
  }
};

Result<void> T4dReader::File::Body::readConnectivity(std::uint64_t offset) {
  if (connectivityOffset_ == offset) return {};
  connectivityOffset_ = 0;
  auto chunk = file_.file_.readChunk(offset, kConnectivity);
  if (!chunk) return pass(chunk.error());
  auto connectivity = decodeConnectivity(chunk->payload, file_.features_);
  if (!connectivity) return file_.file_.damaged(offset, "CONN: " + connectivity.error().message);
  slab_.connectivity = std::move(*connectivity);
  connectivityOffset_ = offset;
  return {};
}

Result<Layer> T4dReader::File::Body::readLayer(std::uint64_t offset) {
  if (offset == 0) return Layer{};
  auto chunk = file_.file_.readChunk(offset, kLayer);
  if (!chunk) return pass(chunk.error());
  auto layer = decodeLayer(chunk->payload, file_.features_);
  if (!layer) return file_.file_.damaged(offset, "LAYR: " + layer.error().message);
  return layer;
}

Result<void> T4dReader::File::Body::readSlab(const IndexRecord& record) {
  ChunkFile& file = file_.file_;
  auto chunk = file.readChunk(record.slab, kSlab);
  if (!chunk) return pass(chunk.error());
  const auto wrong = [&](const std::string& message) {
    return file.damaged(record.slab, "SLAB: " + message);
  };
  auto decoded = decodeSlab(chunk->payload, file_.features_);
  if (!decoded) return wrong(decoded.error().message);
  if (!(record == IndexRecord{record.slab, chunk->header.bytes(), decoded->parts, decoded->time})) {
    return wrong("the index says something else than the slab itself");
  }
  if (auto read = readConnectivity(record.parts.connectivity); !read) return read;
  const Connectivity& connectivity = *slab_.connectivity;

  Layer lower;
  if (record.parts.lower != 0 && record.parts.lower == upperOffset_) {
    lower = std::move(upper_);
  } else {
    auto read = readLayer(record.parts.lower);
    if (!read) return pass(read.error());
    lower = std::move(*read);
  }
  upperOffset_ = 0;
  auto upper = readLayer(record.parts.upper);
  if (!upper) return pass(upper.error());
  if (lower.vertices.size() != connectivity.lowerCount ||
      upper->vertices.size() != connectivity.upperCount ||
      decoded->interior.size() != connectivity.firstMean() - connectivity.lowerCount) {
    return wrong(
        fmt::format("its connectivity has {} lower, {} interior and {} upper vertices, the "
                    "file {}, {} and {}",
                    connectivity.lowerCount, connectivity.firstMean() - connectivity.lowerCount,
                    connectivity.upperCount, lower.vertices.size(), decoded->interior.size(),
                    upper->vertices.size()));
  }
  slab_.timeBegin = record.time.begin;
  slab_.timeEnd = record.time.end;
  slab_.vertices.resize(connectivity.vertexCount);
  auto at = std::copy(lower.vertices.begin(), lower.vertices.end(), slab_.vertices.begin());
  std::copy(decoded->interior.begin(), decoded->interior.end(), at);
  std::copy(upper->vertices.begin(), upper->vertices.end(),
            slab_.vertices.begin() + connectivity.firstUpper());
  setMeans(connectivity, slab_.vertices);
  slab_.attributes = std::move(decoded->attributes);
  if (auto sound = checkSlab(slab_); !sound) return wrong(sound.error().message);
  if (auto sound = checkStorable(connectivity.cellAttributes, slab_.attributes); !sound) {
    return wrong(sound.error().message);
  }
  upper_ = std::move(*upper);
  upperOffset_ = record.parts.upper;
  return {};
}

T4dReader::T4dReader(std::unique_ptr<File> file) : file_(std::move(file)) {}
T4dReader::T4dReader(T4dReader&&) noexcept = default;
T4dReader& T4dReader::operator=(T4dReader&&) noexcept = default;
T4dReader::~T4dReader() = default;

Result<T4dReader> T4dReader::open(const std::filesystem::path& path, T4dOpen how,
                                  const model::Progress& progress) {
  auto chunkFile = ChunkFile::open(path);
  if (!chunkFile) return pass(chunkFile.error());
  auto file = std::make_unique<File>(std::move(*chunkFile));
  auto opened = withinMemory(path.string(), [&] { return file->open(how, progress); });
  if (!opened) return pass(opened.error());
  return T4dReader(std::move(file));
}

const Metadata& T4dReader::metadata() const { return file_->metadata_; }
T4dVersion T4dReader::version() const { return file_->version_; }
bool T4dReader::indexed() const { return file_->indexed_; }
std::uint64_t T4dReader::fileBytes() const { return file_->file_.size(); }
std::uint64_t T4dReader::bytesRead() const { return file_->file_.bytesRead(); }
std::size_t T4dReader::bodyCount() const { return file_->bodies_.size(); }
const BodySummary& T4dReader::summary(std::size_t body) const { return file_->summaries_[body]; }
model::Source& T4dReader::body(std::size_t index) { return file_->bodies_[index]; }
std::uint64_t T4dReader::slabOffset(std::size_t body, std::size_t slab) const {
  return file_->bodies_[body].record(slab).slab;
}
const std::optional<Error>& T4dReader::damage() const { return file_->damage_; }

Result<void> T4dReader::readThrough(std::size_t index, model::Sink& sink,
                                    const model::Progress& progress) {
  BodySummary found;
  class Tally : public model::Sink {
   public:
    Tally(BodySummary& sum, model::Sink& next) : sum_(sum), next_(next) {}
    Result<void> put(const Slab& slab) override {
      addSlab(sum_, slab);
      return next_.put(slab);
    }

   private:
    BodySummary& sum_;
    model::Sink& next_;
  } tally(found, sink);
  if (auto pumped = pump(body(index), tally, progress); !pumped) return pumped;
  if (auto checked = checkSummary(summary(index), found); !checked) {
    return file_->file_.damaged(file_->doneOffset_,
                                fmt::format("DONE: body {}: {}", index, checked.error().message));
  }
  return {};
}

Result<void> checkT4dFile(const std::filesystem::path& path, const model::Progress& progress) {
  class : public model::Sink {
    Result<void> put(const Slab&) override { return {}; }
  } nowhere;
  auto reader = T4dReader::open(path, T4dOpen::Checked, progress);
  if (!reader) return pass(reader.error());
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    if (auto read = reader->readThrough(i, nowhere); !read) return read;
  }
  return {};
}

}  // namespace t4d::formats
