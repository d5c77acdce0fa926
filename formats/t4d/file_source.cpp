#include <atomic>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "formats/t4d/byte_source.h"
#include "platform/kept_inputs.h"

namespace t4d::formats {
namespace {

class FileSource : public ByteSource {
 public:
  explicit FileSource(std::string name) : name_(std::move(name)) {}
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  ~FileSource() override {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  Result<void> open() {
    const auto error = [&](const char* doing) {
      return fail(ErrorCode::Io, fmt::format("cannot {}: {}", doing, std::strerror(errno)), name_);
    };
    // Opening a pipe waits for its writer otherwise.
    descriptor_ = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0) return error("open");
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) return error("open");
    if (S_ISDIR(status.st_mode)) return fail(ErrorCode::Io, "is a folder", name_);
    if (!S_ISREG(status.st_mode)) {
      return fail(ErrorCode::Io, "is not a regular file; slabs are read at their offsets", name_);
    }
    platform::noteInput(status);
    size_ = static_cast<std::uint64_t>(status.st_size);
    return {};
  }

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return size_; }
  std::uint64_t bytesRead() const override { return bytesRead_; }

  Result<void> read(std::uint64_t offset, std::span<std::byte> into) override {
    const auto error = [&](std::uint64_t at, ErrorCode code, std::string message) {
      return Error{code, std::move(message), placeOfByte(name_, at), at};
    };
    for (std::size_t have = 0; have < into.size();) {
      const ssize_t got = ::pread(descriptor_, into.data() + have, into.size() - have,
                                  static_cast<off_t>(offset + have));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        return error(offset, ErrorCode::Io, fmt::format("cannot read: {}", std::strerror(errno)));
      }
      if (got == 0) {
        return error(offset + have, ErrorCode::InvalidInput,
                     "the file has become shorter while it was read");
      }
      have += static_cast<std::size_t>(got);
    }
    bytesRead_ += into.size();
    return {};
  }

 private:
  std::string name_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::atomic<std::uint64_t> bytesRead_ = 0;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> openFileSource(const std::filesystem::path& path) {
  auto source = std::make_unique<FileSource>(path.string());
  if (auto opened = source->open(); !opened) return opened.error();
  return source;
}

}  // namespace t4d::formats
