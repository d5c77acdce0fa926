#include "platform/scratch_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

#include "platform/windows/system_file.h"

namespace t4d::platform {

Result<ScratchFile> ScratchFile::create() {
  const auto cannot = [](const std::string& reason, const std::filesystem::path& where) {
    return fail(ErrorCode::Failed, "cannot make a temporary file (TMP says where): " + reason,
                where.string());
  };
  std::error_code error;
  const auto folder = std::filesystem::temp_directory_path(error);
  if (error) return cannot(error.message(), folder);
  wchar_t name[MAX_PATH];
  if (GetTempFileNameW(folder.c_str(), L"t4d", 0, name) == 0) {
    setErrno();
    return cannot(std::strerror(errno), folder);
  }
  Descriptor descriptor =
      openOnWindows(name, {.access = GENERIC_READ | GENERIC_WRITE,
                           .disposition = TRUNCATE_EXISTING,
                           .flags = FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE});
  if (!descriptor) return cannot(std::strerror(errno), folder);
  return ScratchFile(std::move(descriptor));
}

Result<void> ScratchFile::append(std::span<const std::byte> bytes) {
  // Reading from a place moves that of writing.
  if (SetFilePointerEx(handleOf(descriptor_), {}, nullptr, FILE_END) != 0 &&
      descriptor_.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()})) {
    return {};
  }
  return fail(ErrorCode::Failed, std::string("cannot write a temporary file (TMP says where): ") +
                                     std::strerror(errno));
}

bool ScratchFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  return descriptor_.readAt(offset, into) == static_cast<std::ptrdiff_t>(into.size());
}

}  // namespace t4d::platform
