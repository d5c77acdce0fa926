#include "platform/part_file.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <io.h>

#include "platform/kept_inputs.h"
#include "platform/windows/system_file.h"

namespace t4d::platform {

namespace {

namespace fs = std::filesystem;

constexpr int kStandardOutput = 1;

Error ioError(const fs::path& target, const char* doing) {
  return fail(ErrorCode::Failed, fmt::format("cannot {}: {}", doing, std::strerror(errno)),
              target.string());
}

/// Follows symbolic links to their target, which need not exist. Returns any other path unchanged.
fs::path followLinks(fs::path target) {
  std::error_code ignored;
  while (fs::is_symlink(target, ignored)) {
    target = target.parent_path() / fs::read_symlink(target, ignored);
  }
  return target;
}

/// Waits until an open file is on the disk. What cannot be synced counts as done.
bool sync(const Descriptor& file) {
  if (FlushFileBuffers(handleOf(file)) != 0 || GetLastError() == ERROR_INVALID_FUNCTION)
    return true;
  setErrno();
  return false;
}

fs::path partOf(const fs::path& target, int number) {
  // Leaves room for the rest of the name, which may have 255 characters.
  constexpr std::size_t kNameCharacters = 200;
  fs::path name = ".";
  name += target.filename().native().substr(0, kNameCharacters);
  name += fmt::format(".{}.part", number);
  return target.parent_path() / name;
}

}  // namespace

Result<PartFile> PartFile::create(const fs::path& target) {
  PartFile file;
  if (target == "-") {
    file.target_ = "standard output";
    if (::_isatty(kStandardOutput) != 0) {
      return fail(ErrorCode::Failed, "is a terminal; send it to a file or a pipe",
                  file.target_.string());
    }
    file.descriptor_ = standardStream(kStandardOutput);
    if (!file.descriptor_) return ioError(file.target_, "open for writing");
    return file;
  }
  file.target_ = target;
  std::error_code ignored;
  const auto there = identityOf(target);
  const auto output = informationOf(standardStream(kStandardOutput));
  if (there && output && *there == identityOf(*output)) {
    return fail(ErrorCode::Failed, "is the standard output, where the report goes; name a file",
                target.string());
  }
  const fs::file_status status = fs::status(target, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) {
    file.descriptor_ = openOnWindows(target, {.access = GENERIC_WRITE});
    if (!file.descriptor_) return ioError(target, "open for writing");
    return file;
  }
  if (auto free = file.checkTarget(); !free) return free.error();
  file.target_ = followLinks(std::move(file.target_));
  const auto folder = file.target_.parent_path();
  if (!folder.empty() && !fs::exists(folder, ignored)) {
    return fail(ErrorCode::Failed,
                fmt::format("cannot open for writing: there is no folder {}", folder.string()),
                target.string());
  }
  if (auto created = file.createPart(); !created) return created.error();
  return file;
}

Result<void> PartFile::createPart() {
  // Only processes that write the same file at the same time need more than one number.
  constexpr int kSwept = 8;
  constexpr int kMost = 256;
  for (int i = 1; i <= kSwept; ++i) {
    // What another process writes, and what is read, cannot be deleted: see below.
    const fs::path part = partOf(target_, i);
    const auto there = identityOf(part);
    if (there && !isInput(*there)) DeleteFileW(part.c_str());
  }
  for (int i = 1; i <= kMost; ++i) {
    const fs::path part = partOf(target_, i);
    // Not shared for deletion: this is its lock.
    Descriptor made = openOnWindows(part, {.access = GENERIC_WRITE,
                                           .sharing = FILE_SHARE_READ,
                                           .disposition = CREATE_NEW,
                                           .flags = FILE_ATTRIBUTE_HIDDEN});
    if (!made && errno != EEXIST) break;
    if (!made) continue;
    part_ = part;
    descriptor_ = std::move(made);
    note_ = Cleanup::file(part);
    return {};
  }
  return ioError(target_, "open for writing");
}

PartFile::PartFile(PartFile&& other) noexcept { *this = std::move(other); }

PartFile& PartFile::operator=(PartFile&& other) noexcept {
  if (this == &other) return *this;
  remove();
  target_ = std::move(other.target_);
  part_ = std::exchange(other.part_, {});
  descriptor_ = std::move(other.descriptor_);
  note_ = std::move(other.note_);
  return *this;
}

Result<void> PartFile::write(std::string_view bytes) {
  if (!descriptor_.write(bytes)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::rewrite(std::uint64_t offset, std::string_view bytes) {
  if (!descriptor_.writeAt(offset, bytes)) return ioError(target_, "write");
  return {};
}

Result<void> PartFile::close() {
  Descriptor closing = std::move(descriptor_);
  if (!closing || (sync(closing) && closing.close())) return {};
  return ioError(target_, "write");
}

Result<void> PartFile::checkTarget() const {
  const auto there = identityOf(target_);
  std::error_code ignored;
  if (fs::is_directory(target_, ignored)) {
    return fail(ErrorCode::Failed, "is a folder; name a file in it", target_.string());
  }
  if (!there || !isInput(*there)) return {};
  return fail(ErrorCode::Options, "is an input of this run; name another output", target_.string());
}

Result<void> PartFile::putInPlace(std::span<PartFile> parts) {
  // What is open cannot be renamed. If another process that writes the same file takes a part for
  // a leftover meanwhile, it is missed below.
  for (PartFile& part : parts) {
    if (!part.isDirect()) {
      if (auto free = part.checkTarget(); !free) return free;
    }
    if (auto closed = part.close(); !closed) return closed;
  }
  for (PartFile& part : parts) {
    if (part.isDirect()) continue;
    SetFileAttributesW(part.part_.c_str(), FILE_ATTRIBUTE_NORMAL);
    if (MoveFileExW(part.part_.c_str(), part.target_.c_str(),
                    MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) == 0) {
      setErrno();
      return ioError(part.target_, "put in place");
    }
    part.note_.release();
    part.part_.clear();
  }
  return {};
}

void PartFile::remove() noexcept {
  descriptor_.close();
  if (note_) DeleteFileW(part_.c_str());
  note_.release();
  part_.clear();
}

}  // namespace t4d::platform
