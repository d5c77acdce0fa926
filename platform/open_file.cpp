#include "platform/open_file.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "platform/kept_inputs.h"

namespace t4d::platform {
namespace {

Error cannot(const char* what, const std::string& name) {
  return fail(ErrorCode::Io, fmt::format("cannot {}: {}", what, std::strerror(errno)), name);
}

}  // namespace

Result<OpenFile> OpenFile::open(const std::filesystem::path& path) {
  if (path == "-") {
    return opened(Descriptor(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)), "standard input", nullptr);
  }
  return opened(Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)), path.string(), nullptr);
}

Result<OpenFile> OpenFile::openRegular(const std::filesystem::path& path, const char* notRegular) {
  // Opening a pipe waits for its writer otherwise.
  Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  return opened(std::move(descriptor), path.string(), notRegular);
}

Result<OpenFile> OpenFile::opened(Descriptor descriptor, std::string name, const char* notRegular) {
  struct stat status {};
  if (!descriptor || ::fstat(descriptor.number(), &status) != 0) return cannot("open", name);
  if (S_ISDIR(status.st_mode)) return fail(ErrorCode::Io, "is a folder", name);
  if (notRegular != nullptr && !S_ISREG(status.st_mode)) {
    return fail(ErrorCode::Io, notRegular, name);
  }
  noteInput({status.st_dev, status.st_ino});
  OpenFile file(std::move(descriptor), std::move(name));
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  file.version_ = fmt::format("{:x}-{:x}-{:x}.{:x}", status.st_ino, status.st_size,
                              status.st_mtim.tv_sec, status.st_mtim.tv_nsec);
  return file;
}

Result<std::size_t> OpenFile::read(std::span<std::byte> into) {
  const std::ptrdiff_t got = descriptor_.read(into);
  if (got < 0) return cannot("read", name_);
  return static_cast<std::size_t>(got);
}

Result<std::size_t> OpenFile::readAt(std::uint64_t offset, std::span<std::byte> into) const {
  const std::ptrdiff_t got = descriptor_.readAt(offset, into);
  if (got < 0) return cannot("read", name_);
  return static_cast<std::size_t>(got);
}

void OpenFile::seek(std::uint64_t offset) {
  ::lseek(descriptor_.number(), static_cast<off_t>(offset), SEEK_SET);
}

}  // namespace t4d::platform
