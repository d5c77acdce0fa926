#include "platform/open_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>
#include <io.h>

#include "platform/kept_inputs.h"
#include "platform/windows/system_file.h"

namespace t4d::platform {
namespace {

Error cannot(const char* what, const std::string& name) {
  return fail(ErrorCode::Io, fmt::format("cannot {}: {}", what, std::strerror(errno)), name);
}

}  // namespace

Result<OpenFile> OpenFile::open(const std::filesystem::path& path) {
  if (path == "-") return opened(standardStream(0), "standard input", nullptr);
  return opened(openOnWindows(path, {}), path.string(), nullptr);
}

Result<OpenFile> OpenFile::openRegular(const std::filesystem::path& path, const char* notRegular) {
  return opened(openOnWindows(path, {}), path.string(), notRegular);
}

Result<OpenFile> OpenFile::opened(Descriptor descriptor, std::string name, const char* notRegular) {
  if (!descriptor) return cannot("open", name);
  const auto there = informationOf(descriptor);
  if (!there && notRegular != nullptr) return fail(ErrorCode::Io, notRegular, name);
  if (there && (there->dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0) {
    return fail(ErrorCode::Io, "is a folder", name);
  }
  OpenFile file(std::move(descriptor), std::move(name));
  if (!there) return file;
  const FileIdentity identity = identityOf(*there);
  noteInput(identity);
  file.size_ = std::uint64_t{there->nFileSizeHigh} << 32 | there->nFileSizeLow;
  file.version_ =
      fmt::format("{:x}-{:x}-{:x}.{:x}", identity.number, file.size_,
                  there->ftLastWriteTime.dwHighDateTime, there->ftLastWriteTime.dwLowDateTime);
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
  ::_lseeki64(descriptor_.number(), static_cast<std::int64_t>(offset), SEEK_SET);
}

}  // namespace t4d::platform
