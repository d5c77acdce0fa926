#include "t4d/system/part_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace t4d::system {

namespace {

Error ioError(const std::filesystem::path& target, const char* doing) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

/// Waits until an open file or folder is on the disk, and closes it. A file system that cannot sync
/// counts as done.
bool syncAndClose(int descriptor) {
  const bool done =
      ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP || errno == ENOSYS;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return done;
}

}  // namespace

Result<PartFile> PartFile::create(const std::filesystem::path& target) {
  // Leaves room for the rest of the name, which may have 255 bytes on most file systems.
  constexpr std::size_t kNameBytes = 200;
  constexpr int kTries = 16;
  constexpr mode_t kAnyoneByUmask = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;
  struct stat old {};
  const bool exists = ::lstat(target.c_str(), &old) == 0;
  if (!exists && errno != ENOENT) {
    return ioError(target, "open for writing");  // its name is too long, say
  }
  if (exists && !S_ISREG(old.st_mode) && !S_ISLNK(old.st_mode)) {
    return fail(ErrorCode::Failed,
                S_ISDIR(old.st_mode) ? "is a folder; name a file in it"
                                     : "is a pipe or a device, and this is written to files only",
                target.string());
  }
  const std::string name = target.filename().string().substr(0, kNameBytes);
  std::random_device random;
  for (int i = 0; i < kTries; ++i) {
    PartFile part;
    part.target_ = target;
    part.path_ =
        target.parent_path() / fmt::format(".{}.{:08x}{:08x}.part", name, random(), random());
    int descriptor = -1;
    {
      const HeldCleanup held;
      part.note_ = Cleanup::file(part.path_);
      descriptor =
          ::open(part.path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kAnyoneByUmask);
    }
    if (descriptor >= 0) {
      ::close(descriptor);
      return part;
    }
    const int reason = errno;
    part.note_.release();  // nothing of ours is there
    errno = reason;
    if (reason != EEXIST) break;
  }
  return ioError(target, "open for writing");
}

PartFile::PartFile(PartFile&& other) noexcept { *this = std::move(other); }

PartFile& PartFile::operator=(PartFile&& other) noexcept {
  if (this == &other) return *this;
  remove();
  target_ = std::move(other.target_);
  path_ = std::move(other.path_);
  note_ = std::move(other.note_);
  state_ = std::exchange(other.state_, State::Part);
  return *this;
}

Result<void> PartFile::sync() const {
  const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 || !syncAndClose(descriptor)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::place(bool keepOld) {
  struct stat old {};
  const bool replaces = ::lstat(target_.c_str(), &old) == 0;
  if (keepOld && replaces && !S_ISDIR(old.st_mode)) {
    if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) {
      state_ = State::Exchanged;
      return {};
    }
    if (errno != EINVAL && errno != ENOSYS) return ioError(target_, "put in place");
  }
  if (::rename(path_.c_str(), target_.c_str()) != 0) return ioError(target_, "put in place");
  if (!replaces) state_ = State::Placed;
  return {};
}

void PartFile::undo() noexcept {
  if (state_ == State::Exchanged) {
    ::renameat2(AT_FDCWD, target_.c_str(), AT_FDCWD, path_.c_str(), RENAME_EXCHANGE);
  } else if (state_ == State::Placed) {
    ::rename(target_.c_str(), path_.c_str());
  }
  state_ = State::Part;
}

Result<void> PartFile::putInPlace(std::span<PartFile> parts) {
  if (parts.empty()) return {};
  for (const PartFile& part : parts) {
    if (auto synced = part.sync(); !synced) return synced;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    auto placed = parts[i].place(parts.size() > 1);
    if (placed) continue;
    while (i-- > 0) parts[i].undo();
    return placed;
  }
  const std::filesystem::path target = parts.back().target_;
  for (PartFile& part : parts) {
    if (part.state_ == State::Exchanged) ::unlink(part.path_.c_str());  // the old contents
    part.note_.release();
  }
  return syncNames(target);
}

Result<void> syncNames(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A folder may be writable and not readable.
  if (descriptor < 0 || syncAndClose(descriptor)) return {};
  return ioError(file, "sync the directory");
}

void PartFile::remove() noexcept {
  if (!note_) return;
  ::unlink(path_.c_str());
  note_.release();
}

}  // namespace t4d::system
