#include "platform/temporary_folder.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "platform/unique_folder.h"

namespace t4d::platform {

namespace {

auto cannot(const char* hint, const std::string& reason, const std::filesystem::path& where) {
  return fail(ErrorCode::Failed,
              std::string("cannot make a temporary folder") + hint + ": " + reason, where.string());
}

constexpr const char* kHint = " (TMPDIR says where)";

}  // namespace

Result<TemporaryFolder> TemporaryFolder::create() {
  std::error_code error;
  const auto parent = std::filesystem::temp_directory_path(error);
  if (error) return cannot(kHint, error.message(), parent);
  return make(parent, "t4d-", kHint);
}

Result<TemporaryFolder> TemporaryFolder::createIn(const std::filesystem::path& parent,
                                                  const std::string& prefix) {
  return make(parent, prefix, "");
}

Result<TemporaryFolder> TemporaryFolder::make(const std::filesystem::path& parent,
                                              const std::string& prefix, const char* hint) {
  const HeldCleanup held;
  const auto made = makeUniqueFolder(parent, prefix);
  if (!made) return cannot(hint, std::strerror(errno), parent);
  return TemporaryFolder(*made);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(note_, other.note_);
}

TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(note_, other.note_);
  return *this;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace t4d::platform
