#include "t4d/system/part_file.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace t4d::system {

namespace {

tl::unexpected<Error> ioError(const std::filesystem::path& target, const char* doing) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

/// Waits until all of an open file or folder is on the disk, and closes it. Where a file system
/// cannot do that there is nothing to wait for.
bool syncAndClose(int descriptor) {
  const bool done =
      ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP || errno == ENOSYS;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return done;
}

}  // namespace

PartFile::PartFile(std::filesystem::path target)
    : target_(std::move(target)),
      path_(target_.parent_path() /
            fmt::format(".{}.{}.part", target_.filename().string(), ::getpid())),
      note_(Cleanup::file(path_)) {}

PartFile::PartFile(PartFile&& other) noexcept { *this = std::move(other); }

PartFile& PartFile::operator=(PartFile&& other) noexcept {
  if (this == &other) return *this;
  remove();
  target_ = std::move(other.target_);
  path_ = std::move(other.path_);
  note_ = std::move(other.note_);
  return *this;
}

Result<void> PartFile::sync() const {
  const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 || !syncAndClose(descriptor)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::rename() {
  if (::rename(path_.c_str(), target_.c_str()) != 0) return ioError(target_, "put in place");
  note_.release();
  return {};
}

Result<void> PartFile::putInPlace(std::span<PartFile> parts) {
  if (parts.empty()) return {};
  for (const PartFile& part : parts) {
    if (auto synced = part.sync(); !synced) return synced;
  }
  for (PartFile& part : parts) {
    if (auto renamed = part.rename(); !renamed) return renamed;
  }
  const std::filesystem::path& target = parts.back().target_;
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A folder may be writable and not readable.
  if (descriptor < 0 || syncAndClose(descriptor)) return {};
  return ioError(target, "sync the directory");
}

void PartFile::remove() noexcept {
  if (!note_) return;
  ::unlink(path_.c_str());
  note_.release();
}

}  // namespace t4d::system
