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
  Descriptor descriptor(mkostemp(name.data(), O_CLOEXEC));
  if (!descriptor) return cannot(std::strerror(errno), folder);
  unlink(name.c_str());
  return ScratchFile(std::move(descriptor));
}

Result<void> ScratchFile::append(std::span<const std::byte> bytes) {
  if (descriptor_.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()})) return {};
  return fail(
      ErrorCode::Failed,
      std::string("cannot write a temporary file (TMPDIR says where): ") + std::strerror(errno));
}

bool ScratchFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  return descriptor_.readAt(offset, into) == static_cast<std::ptrdiff_t>(into.size());
}

}  // namespace t4d::platform
