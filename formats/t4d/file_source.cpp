#include <atomic>

#include "formats/t4d/byte_source.h"
#include "platform/open_file.h"

namespace t4d::formats {
namespace {

class FileSource : public ByteSource {
 public:
  explicit FileSource(platform::OpenFile file) : file_(std::move(file)) {}

  const std::string& name() const override { return file_.name(); }
  std::uint64_t size() const override { return file_.size(); }
  std::uint64_t bytesRead() const override { return bytesRead_; }

  Result<void> read(std::uint64_t offset, std::span<std::byte> into) override {
    const auto error = [&](std::uint64_t at, ErrorCode code, std::string message) {
      return Error{code, std::move(message), placeOfByte(name(), at), at};
    };
    const auto got = file_.readAt(offset, into);
    if (!got) return error(offset, got.error().code, got.error().message);
    if (*got < into.size()) {
      return error(offset + *got, ErrorCode::InvalidInput,
                   "the file has become shorter while it was read");
    }
    bytesRead_ += into.size();
    return {};
  }

 private:
  platform::OpenFile file_;
  std::atomic<std::uint64_t> bytesRead_ = 0;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> openFileSource(const std::filesystem::path& path) {
  auto file = platform::OpenFile::openRegular(
      path, "is not a regular file; slabs are read at their offsets");
  if (!file) return file.error();
  return std::make_unique<FileSource>(std::move(*file));
}

}  // namespace t4d::formats
