#include "platform/windows/system_file.h"

#include <cerrno>

#include <fcntl.h>
#include <io.h>

namespace t4d::platform {

int setErrno() {
  switch (GetLastError()) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_INVALID_NAME:
      errno = ENOENT;
      break;
    case ERROR_ACCESS_DENIED:
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION:
    case ERROR_WRITE_PROTECT:
      errno = EACCES;
      break;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS:
      errno = EEXIST;
      break;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
      errno = ENOSPC;
      break;
    case ERROR_INVALID_HANDLE:
      errno = EBADF;
      break;
    case ERROR_BROKEN_PIPE:
    case ERROR_NO_DATA:
      errno = EPIPE;
      break;
    case ERROR_TOO_MANY_OPEN_FILES:
      errno = EMFILE;
      break;
    default:
      errno = EIO;
  }
  return -1;
}

Descriptor openOnWindows(const std::filesystem::path& path, const Opening& how) {
  const HANDLE file = CreateFileW(path.c_str(), how.access, how.sharing, nullptr, how.disposition,
                                  how.flags, nullptr);
  if (file == INVALID_HANDLE_VALUE) return Descriptor(setErrno());
  const int number = _open_osfhandle(reinterpret_cast<std::intptr_t>(file), _O_BINARY);
  if (number < 0) CloseHandle(file);
  return Descriptor(number);
}

HANDLE handleOf(const Descriptor& descriptor) {
  return reinterpret_cast<HANDLE>(_get_osfhandle(descriptor.number()));
}

std::optional<BY_HANDLE_FILE_INFORMATION> informationOf(const Descriptor& descriptor) {
  BY_HANDLE_FILE_INFORMATION file{};
  const HANDLE handle = handleOf(descriptor);
  if (GetFileType(handle) != FILE_TYPE_DISK || GetFileInformationByHandle(handle, &file) == 0) {
    return std::nullopt;
  }
  return file;
}

FileIdentity identityOf(const BY_HANDLE_FILE_INFORMATION& file) {
  return {file.dwVolumeSerialNumber, std::uint64_t{file.nFileIndexHigh} << 32 | file.nFileIndexLow};
}

std::optional<FileIdentity> identityOf(const std::filesystem::path& path) {
  const Descriptor opened = openOnWindows(path, {.access = 0});
  if (!opened) return std::nullopt;
  const auto file = informationOf(opened);
  if (!file) return std::nullopt;
  return identityOf(*file);
}

Descriptor standardStream(int number) {
  Descriptor stream(_dup(number));
  if (stream) _setmode(stream.number(), _O_BINARY);
  return stream;
}

}  // namespace t4d::platform
