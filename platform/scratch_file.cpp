#include "platform/scratch_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace t4d::platform {

Result<ScratchFile> ScratchFile::create() {
  const auto cannot = [](const std::string& reason, const std::filesystem::path& where) {
    return fail(ErrorCode::Failed, "cannot make a temporary file (TMPDIR says where): " + reason,
                where.string());
  };
  std::error_code error;
  const auto folder = std::filesystem::temp_directory_path(error);
  if (error) return cannot(error.message(), folder);
  std::string name = (folder / "t4d-XXXXXX").string();
  const int descriptor = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) return cannot(std::strerror(errno), folder);
  unlink(name.c_str());
  return ScratchFile(descriptor);
}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

Result<void> ScratchFile::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      return fail(ErrorCode::Failed,
                  std::string("cannot write a temporary file (TMPDIR says where): ") +
                      std::strerror(errno));
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

bool ScratchFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  while (!into.empty()) {
    const ssize_t got = pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace t4d::platform
