#include "platform/part_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "platform/kept_inputs.h"

namespace t4d::platform {

namespace {

namespace fs = std::filesystem;

Error ioError(const fs::path& target, const char* doing) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

bool same(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// Whether a file is the one that the standard output goes to; /dev/null takes both.
bool isStandardOutput(const struct stat& file) {
  struct stat output {};
  if (::fstat(STDOUT_FILENO, &output) != 0) return false;
  const bool isNull = S_ISCHR(file.st_mode) && ::isatty(STDOUT_FILENO) == 0;
  return same(output, file) && !isNull;
}

/// Follows symbolic links to their target, which need not exist. Returns any other path unchanged.
fs::path followLinks(fs::path target) {
  std::error_code ignored;
  while (fs::is_symlink(target, ignored)) {
    target = target.parent_path() / fs::read_symlink(target, ignored);
  }
  return target;
}

/// Waits until an open file or folder is on the disk. What cannot be synced counts as done.
bool sync(int descriptor) {
  return ::fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP ||
         errno == ENOSYS;
}

bool syncAndClose(Descriptor descriptor) {
  const bool done = sync(descriptor.number());
  const int reason = errno;
  const bool closed = descriptor.close();
  if (!done) errno = reason;
  return done && closed;
}

/// Waits until the names in the folder of a file are on disk.
Result<void> syncNames(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // A folder may be writable and not readable.
  if (!opened || syncAndClose(std::move(opened))) return {};
  return ioError(file, "sync the directory");
}

fs::path partOf(const fs::path& target, int number) {
  // Leaves room for the rest of the name, which may have 255 bytes on most file systems.
  constexpr std::size_t kNameBytes = 200;
  const std::string name = target.filename().string().substr(0, kNameBytes);
  return target.parent_path() / fmt::format(".{}.{}.part", name, number);
}

/// Removes a part whose process has ended, and so its lock. The part may be what is recovered.
void removeLeftover(const fs::path& part) {
  const Descriptor file(::open(part.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat opened {};
  struct stat named {};
  if (::fstat(file.number(), &opened) == 0 && S_ISREG(opened.st_mode) &&
      !isInput({opened.st_dev, opened.st_ino}) && ::flock(file.number(), LOCK_EX | LOCK_NB) == 0 &&
      ::lstat(part.c_str(), &named) == 0 && same(opened, named)) {
    ::unlink(part.c_str());
  }
}

/// Locks a new part. False if another process took it for a leftover meanwhile. There are file
/// systems without locks, on which leftovers stay.
bool lockPart(const Descriptor& part) {
  struct stat file {};
  const bool taken = ::flock(part.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  return !taken && ::fstat(part.number(), &file) == 0 && file.st_nlink > 0;
}

}  // namespace

Result<PartFile> PartFile::create(const fs::path& target) {
  PartFile file;
  if (target == "-") {
    file.target_ = "standard output";
    if (::isatty(STDOUT_FILENO) == 1) {
      return fail(ErrorCode::Failed, "is a terminal; send it to a file or a pipe",
                  file.target_.string());
    }
    file.descriptor_ = Descriptor(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
    if (!file.descriptor_) return ioError(file.target_, "open for writing");
    return file;
  }
  file.target_ = target;
  struct stat there {};
  const bool exists = ::stat(target.c_str(), &there) == 0;
  if (!exists && errno != ENOENT) return ioError(target, "open for writing");  // a loop of links
  if (exists && isStandardOutput(there)) {
    return fail(ErrorCode::Failed, "is the standard output, where the report goes; name a file",
                target.string());
  }
  if (exists && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode)) {
    file.descriptor_ = Descriptor(::open(target.c_str(), O_WRONLY | O_CLOEXEC));
    if (!file.descriptor_) return ioError(target, "open for writing");
    return file;
  }
  if (auto free = file.checkTarget(); !free) return free.error();
  file.target_ = followLinks(std::move(file.target_));
  std::error_code ignored;
  const auto folder = file.target_.parent_path();
  if (!folder.empty() && !fs::exists(folder, ignored)) {
    return fail(ErrorCode::Failed,
                fmt::format("cannot open for writing: there is no folder {}", folder.string()),
                target.string());
  }
  if (auto created = file.createPart(); !created) return created.error();
  return file;
}

Result<void> PartFile::createPart() {
  // Only processes that write the same file at the same time need more than one number.
  constexpr int kSwept = 8;
  constexpr int kMost = 256;
  constexpr mode_t kAnyoneByUmask = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;
  for (int i = 1; i <= kSwept; ++i) removeLeftover(partOf(target_, i));
  for (int i = 1; i <= kMost; ++i) {
    const fs::path part = partOf(target_, i);
    const HeldCleanup held;
    Descriptor made(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kAnyoneByUmask));
    if (!made && errno != EEXIST) break;
    if (!made || !lockPart(made)) continue;
    part_ = part;
    descriptor_ = std::move(made);
    note_ = Cleanup::file(part);
    return {};
  }
  return ioError(target_, "open for writing");
}

PartFile::PartFile(PartFile&& other) noexcept { *this = std::move(other); }

PartFile& PartFile::operator=(PartFile&& other) noexcept {
  if (this == &other) return *this;
  remove();
  target_ = std::move(other.target_);
  part_ = std::exchange(other.part_, {});
  descriptor_ = std::move(other.descriptor_);
  note_ = std::move(other.note_);
  return *this;
}

Result<void> PartFile::write(std::string_view bytes) {
  if (!descriptor_.write(bytes)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::rewrite(std::uint64_t offset, std::string_view bytes) {
  if (!descriptor_.writeAt(offset, bytes)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::close() {
  if (!descriptor_ || syncAndClose(std::move(descriptor_))) return {};
  return ioError(target_, "write");
}

Result<void> PartFile::checkTarget() const {
  struct stat there {};
  if (::stat(target_.c_str(), &there) != 0) return {};
  if (S_ISDIR(there.st_mode)) {
    return fail(ErrorCode::Failed, "is a folder; name a file in it", target_.string());
  }
  if (!isInput({there.st_dev, there.st_ino})) return {};
  return fail(ErrorCode::Options, "is an input of this run; name another output", target_.string());
}

Result<void> PartFile::putInPlace(std::span<PartFile> parts) {
  for (PartFile& part : parts) {
    if (part.isDirect()) {
      if (auto closed = part.close(); !closed) return closed;
      continue;
    }
    if (auto free = part.checkTarget(); !free) return free;
    // It stays locked until it has its name.
    if (part.descriptor_ && !sync(part.descriptor_.number())) return ioError(part.target_, "write");
  }
  fs::path target;
  for (PartFile& part : parts) {
    if (part.isDirect()) continue;
    if (::rename(part.part_.c_str(), part.target_.c_str()) != 0) {
      return ioError(part.target_, "put in place");
    }
    target = part.target_;
    part.note_.release();
    part.part_.clear();
    part.descriptor_.close();
  }
  return target.empty() ? Result<void>() : syncNames(target);
}

void PartFile::remove() noexcept {
  // Once unlocked, the name may become another process's.
  if (note_) ::unlink(part_.c_str());
  note_.release();
  part_.clear();
  descriptor_.close();
}

}  // namespace t4d::platform
