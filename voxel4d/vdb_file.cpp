#include "voxel4d/vdb_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <streambuf>

#include <fmt/format.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/GridDescriptor.h>

#include "platform/kept_inputs.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {

namespace {

/// The first eight bytes of every .vdb file.
constexpr std::string_view kMagic("\x20\x42\x44\x56\0\0\0\0", 8);

/// If more grids than this are announced, the count is damaged.
constexpr std::int32_t kMaxGrids = 10'000'000;

/// Supported format versions: since 222 each grid states its compression.
constexpr std::uint32_t kOldestVersion = 222;
constexpr std::uint32_t kNewestVersion = 224;

constexpr std::string_view kHalfSuffix = "_HalfFloat";

Error damaged(const Place& where, const std::exception& error) {
  if (const auto* failure = dynamic_cast<const VdbFailure*>(&error)) return failure->error;
  if (dynamic_cast<const VdbDamage*>(&error) != nullptr) return invalid(error.what(), where);
  if (dynamic_cast<const std::ios_base::failure*>(&error) != nullptr) {
    return invalid("is cut off or damaged: it ends before what it announces", where);
  }
  return invalid(fmt::format("is damaged, or of a kind that cannot be read: {}", error.what()),
                 where);
}

/// Part of a file, of which some at a time is in memory; positions are relative to the file. Trees
/// are read in steps of a few bytes with a look back now and then, for which std::filebuf drops
/// what it has read.
class PartOfFile : public std::streambuf {
 public:
  PartOfFile(std::istream& file, std::int64_t begin, std::int64_t end)
      : file_(file), begin_(begin), end_(end), windowBegin_(begin) {}

 protected:
  int_type underflow() override {
    return moveTo(position()) ? traits_type::to_int_type(*gptr()) : traits_type::eof();
  }
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode which) override {
    const off_type base = from == std::ios::cur ? position() : from == std::ios::end ? end_ : 0;
    return seekpos(base + offset, which);
  }
  pos_type seekpos(pos_type target, std::ios::openmode /*which*/) override {
    const off_type to = target;
    if (to < begin_ || to > end_) return pos_type(off_type(-1));
    if (to >= windowBegin_ && to <= windowBegin_ + (egptr() - eback())) {
      setg(eback(), eback() + (to - windowBegin_), egptr());
    } else {
      setg(nullptr, nullptr, nullptr);
      windowBegin_ = to;
    }
    return target;
  }

 private:
  off_type position() const { return windowBegin_ + (gptr() - eback()); }

  /// Reads the window that begins there; false at the end.
  bool moveTo(off_type to) {
    window_.resize(static_cast<std::size_t>(std::min<off_type>(kWindow, end_ - to)));
    windowBegin_ = to;
    setg(window_.data(), window_.data(), window_.data() + window_.size());
    if (window_.empty()) return false;
    file_.clear();
    file_.seekg(to);
    file_.read(window_.data(), static_cast<std::streamsize>(window_.size()));
    return true;
  }

  static constexpr off_type kWindow = off_type{1} << 20U;
  std::istream& file_;  // throws
  off_type begin_;
  off_type end_;
  off_type windowBegin_;
  std::vector<char> window_;
};

constexpr auto kThrowing = std::ios::failbit | std::ios::badbit | std::ios::eofbit;

/// A grid without its tree.
struct Beginning {
  openvdb::GridBase::Ptr grid;
  VdbCoding coding;
};

/// Reads metadata of the types that we use; others are skipped.
void readMetadata(VdbStream& stream, openvdb::MetaMap& into) {
  const auto count = stream.take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name = stream.text();
    const std::string type = stream.text();
    const auto number = [&]<class Metadata>(Metadata metadata) {
      if (type != Metadata::staticTypeName()) return false;
      const auto size = stream.take<std::uint32_t>();
      require(size == sizeof metadata.value(), "is damaged: its metadata '{}' has {} bytes", name,
              size);
      metadata.value() = stream.take<std::decay_t<decltype(metadata.value())>>();
      into.insertMeta(name, metadata);
      return true;
    };
    if (number(openvdb::DoubleMetadata()) || number(openvdb::FloatMetadata()) ||
        number(openvdb::Int32Metadata()) || number(openvdb::Int64Metadata()) ||
        number(openvdb::Vec3IMetadata())) {
      continue;
    }
    if (type == openvdb::StringMetadata::staticTypeName()) {
      into.insertMeta(name, openvdb::StringMetadata(stream.text()));
    } else if (type == openvdb::BoolMetadata::staticTypeName()) {
      const auto size = stream.take<std::uint32_t>();
      const auto flag = stream.take<std::uint8_t>();
      require(size == 1 && flag <= 1, "is damaged: its metadata '{}' is not true or false", name);
      into.insertMeta(name, openvdb::BoolMetadata(flag == 1));
    } else {
      stream.skip(stream.take<std::uint32_t>());
    }
  }
}

openvdb::math::Transform::Ptr readTransform(VdbStream& stream) {
  const std::string type = stream.text();
  if (type == openvdb::math::NonlinearFrustumMap::mapType()) {
    // No supported grid uses one, and it contains another map, which may be one again, and so on.
    return openvdb::math::Transform::createFrustumTransform({{0, 0, 0}, {1, 1, 1}}, 1, 1);
  }
  require(openvdb::math::MapRegistry::isRegistered(type), "has a transform of the unknown type {}",
          type);
  const auto map = openvdb::math::MapRegistry::createMap(type);
  map->read(stream.stream());
  return transformBy(*map);
}

Beginning readBeginning(VdbStream& stream, const std::string& gridType) {
  Beginning beginning;
  beginning.grid = openvdb::GridBase::createGrid(gridType);
  beginning.coding.compression = stream.take<std::uint32_t>();
  constexpr std::uint32_t kKnown =
      openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC;
  require((beginning.coding.compression & ~kKnown) == 0, "is compressed in an unknown way, {:#x}",
          beginning.coding.compression);
  readMetadata(stream, *beginning.grid);
  beginning.coding.half = beginning.grid->saveFloatAsHalf();
  beginning.grid->setTransform(readTransform(stream));
  return beginning;
}

/// Checks the counts that the writer stored in the metadata.
void checkStatistics(const openvdb::GridBase& grid, std::uint64_t activeVoxels) {
  const auto voxels = grid.getMetadata<openvdb::Int64Metadata>("file_voxel_count");
  const auto count = static_cast<std::int64_t>(activeVoxels);
  require(!voxels || voxels->value() == count,
          "is damaged: it announces {} active voxels and has {}", voxels ? voxels->value() : 0,
          count);
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
  platform::noteInput(path);
  std::unique_ptr<VdbFile> file(new VdbFile);
  file->path_ = path;
  file->stream_.open(path, std::ios::binary);
  if (!file->stream_) {
    return fail(ErrorCode::Io, fmt::format("cannot open: {}", std::strerror(errno)), path.string());
  }
  file->size_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  std::string magic(kMagic.size(), '\0');
  file->stream_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (!file->stream_ || magic != kMagic) {
    if (file->size_ == 0) return invalid("is empty", path.string());
    return invalid("is not a VDB file", path.string(), Remedy::FrameFormat);
  }
  file->stream_.seekg(0);
  // OpenVDB does not check whether its reads succeed.
  file->stream_.exceptions(kThrowing);
  try {
    file->readDirectory();
  } catch (const std::exception& exception) {
    return damaged(path.string(), exception);
  }
  return file;
}

void VdbFile::readDirectory() {
  VdbStream stream(stream_, size_);
  stream.skip(kMagic.size());
  const auto version = stream.take<std::uint32_t>();
  require(version >= kOldestVersion && version <= kNewestVersion,
          "is of version {} of the VDB format; versions {} to {} can be read", version,
          kOldestVersion, kNewestVersion);
  constexpr std::uint64_t kLibraryVersion = 8;
  stream.skip(kLibraryVersion);
  hasOffsets_ = stream.take<std::uint8_t>() != 0;
  constexpr std::uint64_t kUuid = 36;
  stream.skip(kUuid);
  openvdb::MetaMap ignored;
  readMetadata(stream, ignored);
  const auto count = stream.take<std::int32_t>();
  require(count >= 0 && count <= kMaxGrids, "is damaged: it announces {} grids", count);
  for (std::int32_t i = 0; i < count; ++i) readEntry(stream);
}

void VdbFile::readEntry(VdbStream& stream) {
  using openvdb::io::GridDescriptor;
  Entry entry;
  Place place;
  place.uniqueName = stream.text();
  place.gridType = stream.text();
  // The metadata also says whether the values are halves.
  if (place.gridType.ends_with(kHalfSuffix)) {
    place.gridType.resize(place.gridType.size() - kHalfSuffix.size());
  }
  place.parent = stream.text();
  entry.name = GridDescriptor::stripSuffix(place.uniqueName);
  entry.label = GridDescriptor::nameAsString(place.uniqueName);
  entry.where = placeIn(path_.string(), fmt::format("grid '{}'", entry.label));
  require(openvdb::GridBase::isRegistered(place.gridType) &&
              (hasOffsets_ || canReadVdbTree(place.gridType)),
          "its grid '{}' is of type {}; float, double, bool and mask grids can be used", entry.name,
          place.gridType);
  const auto begin = stream.take<std::int64_t>();
  stream.take<std::int64_t>();  // where the values of the leaf nodes begin
  const auto end = stream.take<std::int64_t>();
  if (hasOffsets_) {
    require(end <= size_, "is cut off: its grid '{}' ends at byte {}, the file has {}", entry.label,
            end, size_);
    require(begin >= stream.position() && begin <= end,
            "is damaged: its grid '{}' is said to go from byte {} to {}", entry.label, begin, end);
    place.begin = begin;
    place.end = end;
    VdbStream part(stream_, end);
    part.seek(begin);
    entry.header = readBeginning(part, place.gridType).grid;
    stream.seek(end);
  } else {
    place.begin = stream.position();
    const auto [grid, coding] = readBeginning(stream, place.gridType);
    if (place.parent.empty()) readVdbTree(stream, place.gridType, coding, {});
    place.end = stream.position();
    entry.header = grid;
  }
  entries_.push_back(std::move(entry));
  places_.push_back(std::move(place));
}

VdbGrid VdbFile::readGrid(std::size_t index, const VdbTreeOptions& options) {
  const Place& place = places_[index];
  require(canReadVdbTree(place.gridType),
          "is of type {}; float, double, bool and mask grids can be used", place.gridType);
  PartOfFile part(stream_, place.begin, place.end);
  std::istream file(&part);
  file.exceptions(kThrowing);
  VdbStream stream(file, place.end);
  stream.seek(place.begin);
  auto [grid, coding] = readBeginning(stream, place.gridType);
  VdbTree tree;
  if (place.parent.empty()) {
    tree = readVdbTree(stream, place.gridType, coding, options);
    grid->setTree(tree.tree);
  }
  require(stream.position() == place.end, "is damaged: it ends at byte {} instead of {}",
          stream.position(), place.end);
  if (place.parent.empty()) {
    checkStatistics(*grid, tree.activeVoxels);
    return {grid, std::move(tree.values)};
  }
  // The grid shares the tree of another grid.
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i].uniqueName != place.parent || !places_[i].parent.empty()) continue;
    VdbGrid parent = readGrid(i, options);
    grid->setTree(parent.grid->baseTreePtr());
    return {grid, std::move(parent.values)};
  }
  throw VdbDamage("is damaged: it shares the tree of a grid that is not there");
}

Result<VdbGrid> VdbFile::read(std::size_t index, const VdbTreeOptions& options) {
  try {
    return readGrid(index, options);
  } catch (const std::exception& exception) {
    return damaged(entries_[index].where, exception);
  }
}

}  // namespace t4d::voxel4d
