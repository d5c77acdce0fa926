#include "voxel4d/vdb_file.h"

#include <algorithm>
#include <stdexcept>
#include <streambuf>

#include <fmt/format.h>

#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {

namespace {

/// The first eight bytes of every .vdb.
constexpr std::string_view kMagic("\x20\x42\x44\x56\0\0\0\0", 8);

/// Where more grids than this are announced the count is damaged.
constexpr std::int32_t kMaxGrids = 10'000'000;

/// What our own checks throw; its text is a sentence that needs nothing before it.
struct Damage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void require(bool condition, const std::string& otherwise) {
  if (!condition) throw Damage(otherwise);
}

tl::unexpected<Error> damaged(const std::string& where, const std::exception& error) {
  if (dynamic_cast<const Damage*>(&error) != nullptr) return invalid(error.what(), where);
  if (dynamic_cast<const std::ios_base::failure*>(&error) != nullptr) {
    return invalid("is cut off or damaged: it ends before what it announces", where);
  }
  return invalid(fmt::format("is damaged, or of a kind that cannot be read: {}", error.what()),
                 where);
}

/// Part of a file in memory; positions are those in the file.
class PartInMemory : public std::streambuf {
 public:
  PartInMemory(std::istream& file, std::int64_t begin, std::int64_t end)
      : bytes_(static_cast<std::size_t>(end - begin)), begin_(begin) {
    file.clear();
    file.seekg(begin);
    file.read(bytes_.data(), end - begin);
    setg(bytes_.data(), bytes_.data(), bytes_.data() + bytes_.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode which) override {
    off_type base = begin_;
    if (from == std::ios::cur) base += gptr() - eback();
    if (from == std::ios::end) base += static_cast<off_type>(bytes_.size());
    return seekpos(base + offset, which);
  }
  pos_type seekpos(pos_type position, std::ios::openmode /*which*/) override {
    const off_type at = position - pos_type(begin_);
    if (at < 0 || at > static_cast<off_type>(bytes_.size())) return pos_type(off_type(-1));
    setg(eback(), eback() + at, egptr());
    return position;
  }

 private:
  std::vector<char> bytes_;
  std::int64_t begin_;
};

constexpr auto kThrowing = std::ios::failbit | std::ios::badbit | std::ios::eofbit;

/// What the writer counted must be there.
void checkStatistics(const openvdb::GridBase& grid) {
  const auto voxels = grid.getMetadata<openvdb::Int64Metadata>("file_voxel_count");
  const auto count = static_cast<std::int64_t>(grid.activeVoxelCount());
  if (voxels && voxels->value() != count) {
    throw Damage(fmt::format("is damaged: it announces {} active voxels and has {}",
                             voxels->value(), count));
  }
}

}  // namespace

Result<std::unique_ptr<VdbFile>> VdbFile::open(const std::filesystem::path& path) {
  initializeOpenVdb();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    return fail(ErrorCode::Io, "cannot open: No such file or directory", path.string());
  }
  if (!std::filesystem::is_regular_file(status)) {
    return fail(ErrorCode::Io, "is not a regular file", path.string());
  }
  std::unique_ptr<VdbFile> file(new VdbFile);
  file->path_ = path;
  file->stream_.open(path, std::ios::binary);
  if (!file->stream_) return fail(ErrorCode::Io, "cannot open for reading", path.string());
  file->size_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  std::string magic(kMagic.size(), '\0');
  file->stream_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (!file->stream_ || magic != kMagic) {
    return invalid(file->size_ == 0 ? "is empty" : "is not a VDB file", path.string());
  }
  file->stream_.seekg(0);
  // OpenVDB does not look whether what it reads is there.
  file->stream_.exceptions(kThrowing);
  try {
    file->readDirectory();
  } catch (const std::exception& exception) {
    return damaged(path.string(), exception);
  }
  return file;
}

void VdbFile::tie(std::istream& stream) {
  openvdb::io::setStreamMetadataPtr(stream, metadata_, /*transfer=*/true);
  setFormatVersion(stream);
  setLibraryVersion(stream);
  setDataCompression(stream);
}

void VdbFile::readDirectory() {
  readHeader(stream_);
  metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
  metadata_->setSeekable(true);
  tie(stream_);
  openvdb::MetaMap ignored;
  ignored.readMeta(stream_);
  const std::int32_t count = readGridCount(stream_);
  require(count >= 0 && count <= kMaxGrids,
          fmt::format("is damaged: it announces {} grids", count));
  for (std::int32_t i = 0; i < count; ++i) readEntry();
}

void VdbFile::readEntry() {
  Entry entry;
  Place place;
  try {
    entry.header = place.descriptor.read(stream_);
  } catch (const openvdb::LookupError&) {
    throw Damage(
        fmt::format("its grid '{}' is of type {}; float, double, bool and mask grids can "
                    "be used",
                    place.descriptor.gridName(), place.descriptor.gridType()));
  }
  const auto& descriptor = place.descriptor;
  entry.name = openvdb::io::GridDescriptor::stripSuffix(descriptor.gridName());
  entry.label = openvdb::io::GridDescriptor::nameAsString(descriptor.uniqueName());
  entry.where = fmt::format("{}: grid '{}'", path_.string(), entry.label);
  if (inputHasGridOffsets()) {
    place.begin = descriptor.getGridPos();
    place.end = descriptor.getEndPos();
    require(place.end <= size_,
            fmt::format("is cut off: its grid '{}' ends at byte {}, the file has {}", entry.label,
                        place.end, size_));
    require(place.begin >= stream_.tellg() && place.begin <= place.end,
            fmt::format("is damaged: its grid '{}' is said to go from byte {} to {}", entry.label,
                        place.begin, place.end));
    stream_.seekg(place.begin);
    readGridCompression(stream_);
    entry.header->readMeta(stream_);
    entry.header->readTransform(stream_);
    stream_.seekg(place.end);
  } else {
    place.begin = stream_.tellg();
    readGrid(entry.header, descriptor, stream_, openvdb::CoordBBox());
    place.end = stream_.tellg();
    entry.header = entry.header->copyGridWithNewTree();
  }
  entries_.push_back(std::move(entry));
  places_.push_back(std::move(place));
}

openvdb::GridBase::Ptr VdbFile::readTree(std::size_t index) {
  const auto& descriptor = places_[index].descriptor;
  const std::int64_t begin = places_[index].begin;
  const std::int64_t end = places_[index].end;
  PartInMemory part(stream_, begin, end);
  const auto readWith = [&](const auto&... clip) {
    std::istream stream(&part);
    stream.exceptions(kThrowing);
    tie(stream);
    auto grid = openvdb::GridBase::createGrid(descriptor.gridType());
    if (descriptor.saveFloatAsHalf()) grid->setSaveFloatAsHalf(true);
    stream.seekg(begin);
    readGrid(grid, descriptor, stream, clip...);
    const std::int64_t stop = stream.tellg();
    require(stop == end, fmt::format("is damaged: it ends at byte {} instead of {}", stop, end));
    return grid;
  };
  readWith(openvdb::CoordBBox());
  auto grid = readWith();
  if (!descriptor.isInstance()) {
    checkStatistics(*grid);
    return grid;
  }
  // Its tree is another grid's.
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto& other = places_[i].descriptor;
    if (other.uniqueName() != descriptor.instanceParentName() || other.isInstance()) continue;
    grid->setTree(readTree(i)->baseTreePtr());
    return grid;
  }
  throw Damage("is damaged: it shares the tree of a grid that is not there");
}

Result<openvdb::GridBase::Ptr> VdbFile::read(std::size_t index) {
  try {
    return readTree(index);
  } catch (const std::exception& exception) {
    return damaged(entries_[index].where, exception);
  }
}

}  // namespace t4d::voxel4d
