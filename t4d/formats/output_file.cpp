#include "t4d/formats/output_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace t4d::formats {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

Error ioError(const std::filesystem::path& target, const char* doing) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

/// Whether a file is the one that the standard output goes to; /dev/null takes both.
bool isStandardOutput(const struct stat& file) {
  struct stat output {};
  if (::fstat(STDOUT_FILENO, &output) != 0) return false;
  const bool same = output.st_dev == file.st_dev && output.st_ino == file.st_ino;
  const bool isNull = S_ISCHR(file.st_mode) && ::isatty(STDOUT_FILENO) == 0;
  return same && !isNull;
}

}  // namespace

std::filesystem::path followLinks(std::filesystem::path target) {
  std::error_code ignored;
  while (std::filesystem::is_symlink(target, ignored)) {
    target = target.parent_path() / std::filesystem::read_symlink(target, ignored);
  }
  return target;
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
  OutputFile file;
  if (target == "-") {
    file.target_ = "standard output";
    if (::isatty(STDOUT_FILENO) == 1) {
      return fail(ErrorCode::Failed, "is a terminal; send it to a file or a pipe",
                  file.target_.string());
    }
    file.descriptor_ = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (file.descriptor_ < 0) return ioError(file.target_, "open for writing");
    file.buffer_.reserve(kBufferBytes);
    return file;
  }
  file.target_ = target;
  struct stat there {};
  const bool exists = ::stat(target.c_str(), &there) == 0;
  if (!exists && errno != ENOENT)
    return ioError(target, "open for writing");  // a loop of links, say
  if (exists && S_ISDIR(there.st_mode)) {
    return fail(ErrorCode::Failed, "is a folder; name a file in it", target.string());
  }
  if (exists && isStandardOutput(there)) {
    return fail(ErrorCode::Failed, "is the standard output, where the report goes; name a file",
                target.string());
  }
  if (exists && !S_ISREG(there.st_mode)) {
    file.descriptor_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    std::error_code ignored;
    file.target_ = followLinks(std::move(file.target_));
    const auto folder = file.target_.parent_path();
    if (!folder.empty() && !std::filesystem::exists(folder, ignored)) {
      return fail(ErrorCode::Failed,
                  fmt::format("cannot open for writing: there is no folder {}", folder.string()),
                  target.string());
    }
    auto part = system::PartFile::create(file.target_);
    if (!part) return part.error();
    file.part_ = std::move(*part);
    file.descriptor_ = ::open(file.part_.path().c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW);
  }
  if (file.descriptor_ < 0) return ioError(target, "open for writing");
  file.buffer_.reserve(kBufferBytes);
  return file;
}

Result<OutputFile> OutputFile::openToRewrite(const std::filesystem::path& file, Sharing sharing) {
  OutputFile out;
  out.target_ = file;
  out.descriptor_ = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (out.descriptor_ < 0) return ioError(file, "open for writing");
  const int lock = (sharing == Sharing::Alone ? LOCK_EX : LOCK_SH) | LOCK_NB;
  if (::flock(out.descriptor_, lock) != 0 && errno == EWOULDBLOCK) {
    return fail(ErrorCode::Failed, "another process writes to it", file.string());
  }
  // Whoever had it alone may have given it another name.
  struct stat opened {};
  struct stat named {};
  const bool same = ::fstat(out.descriptor_, &opened) == 0 && ::stat(file.c_str(), &named) == 0 &&
                    opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
  if (!same) {
    return fail(ErrorCode::Failed, "another process has given it another name", file.string());
  }
  out.stays_ = true;
  return out;
}

OutputFile::OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  close();
  target_ = std::move(other.target_);
  part_ = std::move(other.part_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  stays_ = other.stays_;
  size_ = other.size_;
  buffer_ = std::move(other.buffer_);
  return *this;
}

void OutputFile::close() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

Result<void> OutputFile::flush() {
  const std::byte* from = buffer_.data();
  std::size_t left = buffer_.size();
  while (left > 0) {
    const ssize_t written = ::write(descriptor_, from, left);
    if (written < 0) {
      if (errno == EINTR) continue;
      return ioError(target_, "write");
    }
    from += written;
    left -= static_cast<std::size_t>(written);
  }
  buffer_.clear();
  return {};
}

Result<void> OutputFile::write(const void* data, std::size_t size) {
  const auto* from = static_cast<const std::byte*>(data);
  size_ += size;
  while (size > 0) {
    const std::size_t now = std::min(size, kBufferBytes - buffer_.size());
    buffer_.insert(buffer_.end(), from, from + now);
    from += now;
    size -= now;
    if (buffer_.size() == kBufferBytes) {
      if (auto done = flush(); !done) return done;
    }
  }
  return {};
}

Result<void> OutputFile::skip(std::uint64_t bytes) {
  if (auto done = flush(); !done) return done;
  size_ += bytes;
  if (::lseek(descriptor_, static_cast<off_t>(bytes), SEEK_CUR) < 0) {
    return ioError(target_, "leave room");
  }
  return {};
}

Result<void> OutputFile::rewrite(std::uint64_t offset, const void* data, std::size_t size) {
  if (auto done = flush(); !done) return done;
  const auto* from = static_cast<const std::byte*>(data);
  while (size > 0) {
    const ssize_t written = ::pwrite(descriptor_, from, size, static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      return ioError(target_, "write");
    }
    from += written;
    offset += static_cast<std::uint64_t>(written);
    size -= static_cast<std::size_t>(written);
  }
  return {};
}

Result<void> OutputFile::finish(std::string_view bytes) {
  return write(bytes.data(), bytes.size()).and_then([&] { return commit(); });
}

Result<void> OutputFile::commitAll(std::span<OutputFile> files) {
  for (OutputFile& file : files) {
    if (auto done = file.flush(); !done) return done;
    if (file.stays_ && ::fsync(file.descriptor_) != 0) return ioError(file.target_, "write");
    if (::close(std::exchange(file.descriptor_, -1)) != 0) return ioError(file.target_, "write");
  }
  std::vector<system::PartFile> parts;
  for (OutputFile& file : files) {
    // Devices and pipes are not renamed.
    if (file.part_) parts.push_back(std::move(file.part_));
  }
  return system::PartFile::putInPlace(parts);
}

Result<void> writeOutputFile(const std::filesystem::path& target, std::string_view bytes) {
  auto file = OutputFile::create(target);
  if (!file) return file.error();
  return file->finish(bytes);
}

}  // namespace t4d::formats
