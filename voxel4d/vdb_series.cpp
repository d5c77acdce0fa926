#include "voxel4d/vdb_series.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <fmt/format.h>
#include <openvdb/io/Archive.h>

#include "platform/replaceable.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {

namespace fs = std::filesystem;

namespace {

// Where the UUID of a file is: after magic number, versions and a flag.
constexpr std::size_t kUuidAt = 21;
constexpr std::size_t kUuidLength = 36;

/// Replaces the UUID of a file by one of its other bytes.
void setUuid(std::string& bytes) {
  bytes.replace(kUuidAt, kUuidLength, kUuidLength, '0');
  const boost::uuids::name_generator_sha1 named(boost::uuids::ns::oid());
  bytes.replace(kUuidAt, kUuidLength, to_string(named(bytes.data(), bytes.size())));
}

/// Encodes OpenVDB's files; its own io::File does not notice a full disk.
struct Encoder : private openvdb::io::Archive {
  using Archive::write;
  static void encode(std::ostream& out, const openvdb::GridBase::Ptr& grid) {
    Encoder().Archive::write(out, openvdb::GridPtrVec{grid}, /*seekable=*/true);
  }
};

/// The bytes of a file. The random UUID is replaced by one of the contents, so that the same grid
/// makes the same bytes.
std::string bytesOf(const openvdb::GridBase::Ptr& grid) {
  std::ostringstream out;
  out.exceptions(std::ios::failbit | std::ios::badbit);
  Encoder::encode(out, grid);
  std::string bytes = std::move(out).str();
  setUuid(bytes);
  return bytes;
}

/// Starts a file that has the bytes of a grid, and adds their number to `size`.
Result<platform::PartFile> vdbPart(const fs::path& target, const openvdb::GridBase::Ptr& grid,
                                   std::uint64_t& size) {
  auto part = platform::PartFile::create(target);
  if (!part) return part;
  std::string bytes;
  try {
    bytes = bytesOf(grid);
  } catch (const std::exception& exception) {
    return fail(ErrorCode::Failed, fmt::format("OpenVDB cannot write: {}", exception.what()),
                target.string());
  }
  if (auto written = part->write(bytes); !written) return written.error();
  size = bytes.size();
  return part;
}

}  // namespace

Result<std::uint64_t> writeVdb(const fs::path& path, const openvdb::GridBase::Ptr& grid) {
  std::uint64_t size = 0;
  auto part = vdbPart(path, grid, size);
  if (!part) return part.error();
  if (auto put = platform::PartFile::putInPlace({&*part, 1}); !put) return put.error();
  return size;
}

Result<void> checkVdbContents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file) return fail(ErrorCode::Io, "cannot be read", path.string());
  std::string expected = bytes;
  if (bytes.size() >= kUuidAt + kUuidLength) setUuid(expected);
  if (bytes == expected) return {};
  return invalid("is damaged, or was changed by another program: its UUID is not that of its bytes",
                 path.string());
}

Result<VdbSeries> VdbSeries::create(const fs::path& folder, std::size_t frames,
                                    const model::Part& part) {
  initializeOpenVdb();
  VdbSeries series;
  const std::size_t width = std::max<std::size_t>(4, fmt::formatted_size("{}", frames - 1));
  std::set<std::string> names;  // of all parts
  const model::PartRange own = part.of(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto name = names.insert(fmt::format("frame_{:0{}}.vdb", i, width)).first;
    if (i >= own.begin && i < own.end) series.names_.push_back(*name);
  }
  std::error_code error;
  if (fs::exists(folder, error)) {
    if (!fs::is_directory(folder, error)) {
      return fail(ErrorCode::Failed, "is not a folder", folder.string());
    }
    std::set<std::string> others;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      if (entry.path().extension() == ".vdb" && !names.contains(name)) others.insert(name);
    }
    if (error) return fail(ErrorCode::Failed, "cannot read the folder: " + error.message(), folder);
    if (!others.empty()) {
      return fail(ErrorCode::Failed,
                  fmt::format("the folder has other .vdb files ({}{}), which would pass for frames "
                              "of this series; remove them or name another folder",
                              *others.begin(), others.size() > 1 ? ", ..." : ""),
                  folder.string());
    }
    if (auto good = platform::checkReplaceable(folder, series.names_); !good) {
      return good.error();
    }
  } else {
    const platform::HeldCleanup held;
    fs::create_directories(folder, error);
    if (error) {
      return fail(ErrorCode::Failed, "cannot make the folder: " + error.message(), folder.string());
    }
    series.madeFolder_ = platform::Cleanup::emptyFolder(folder);
  }
  series.folder_ = folder;
  return series;
}

VdbSeries::VdbSeries(VdbSeries&& other) noexcept
    : folder_(std::move(other.folder_)),
      madeFolder_(std::move(other.madeFolder_)),
      names_(std::exchange(other.names_, {})),
      parts_(std::exchange(other.parts_, {})) {}

VdbSeries::~VdbSeries() {
  parts_.clear();
  // Removes the folder only if it is empty.
  std::error_code ignored;
  if (madeFolder_) fs::remove(folder_, ignored);
}

Result<std::uint64_t> VdbSeries::put(const openvdb::GridBase::Ptr& grid) {
  std::uint64_t size = 0;
  auto part = vdbPart(folder_ / nextName(), grid, size);
  if (!part) return part.error();
  if (auto closed = part->close(); !closed) return closed.error();
  parts_.push_back(std::move(*part));
  return size;
}

Result<void> VdbSeries::commit() {
  if (auto put = platform::PartFile::putInPlace(parts_); !put) return put;
  parts_.clear();
  names_.clear();
  madeFolder_.release();
  return {};
}

}  // namespace t4d::voxel4d
