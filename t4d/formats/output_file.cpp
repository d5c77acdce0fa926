#include "t4d/formats/output_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace t4d::formats {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

tl::unexpected<Error> ioError(const std::filesystem::path& target, const char* doing) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
  OutputFile file;
  std::error_code ignored;
  file.target_ = std::filesystem::is_symlink(target, ignored)
                     ? std::filesystem::weakly_canonical(target, ignored)
                     : target;
  if (std::filesystem::is_directory(file.target_, ignored)) {
    return fail(ErrorCode::Failed, "is a folder; name a file in it", target.string());
  }
  const bool direct = std::filesystem::exists(file.target_, ignored) &&
                      !std::filesystem::is_regular_file(file.target_, ignored);
  if (direct) {
    file.descriptor_ = ::open(file.target_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    auto part = system::PartFile::create(file.target_);
    if (!part) return pass(part.error());
    file.part_ = std::move(*part);
    file.descriptor_ = ::open(file.part_.path().c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW);
  }
  if (file.descriptor_ < 0) return ioError(target, "open for writing");
  file.buffer_.reserve(kBufferBytes);
  return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  close();
  target_ = std::move(other.target_);
  part_ = std::move(other.part_);
  descriptor_ = std::exchange(other.descriptor_, -1);
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

Result<void> OutputFile::commit() {
  if (auto done = flush(); !done) return done;
  if (::close(std::exchange(descriptor_, -1)) != 0) return ioError(target_, "write");
  // Devices and pipes are not renamed.
  return part_ ? system::PartFile::putInPlace({&part_, 1}) : Result<void>();
}

}  // namespace t4d::formats
