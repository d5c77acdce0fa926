#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>

#include "platform/descriptor.h"
#include "platform/kept_inputs.h"

/// Files as Windows has them, for the files of this folder alone.
namespace t4d::platform {

/// Sets errno to what GetLastError says. Returns -1.
int setErrno();

struct Opening {
  DWORD access = GENERIC_READ;
  /// As elsewhere, an open file may be renamed, replaced and removed.
  DWORD sharing = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
  DWORD disposition = OPEN_EXISTING;
  DWORD flags = FILE_FLAG_BACKUP_SEMANTICS;  ///< a folder is opened, too
};
/// A descriptor of bytes, not of text. What fails sets errno.
Descriptor openOnWindows(const std::filesystem::path& path, const Opening& how);

HANDLE handleOf(const Descriptor& descriptor);

/// What the system knows of an open file; none if it is not on a disk.
std::optional<BY_HANDLE_FILE_INFORMATION> informationOf(const Descriptor& descriptor);
FileIdentity identityOf(const BY_HANDLE_FILE_INFORMATION& file);

/// Another descriptor of a standard stream, of bytes, not of text.
Descriptor standardStream(int number);

}  // namespace t4d::platform
