#include "t4d/system/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

namespace t4d::system {

Result<TemporaryFolder> TemporaryFolder::create() {
  const auto cannot = [](const std::string& reason, const std::filesystem::path& where) {
    return fail(ErrorCode::Failed, "cannot make a temporary folder (TMPDIR says where): " + reason,
                where.string());
  };
  std::error_code error;
  const auto parent = std::filesystem::temp_directory_path(error);
  if (error) return cannot(error.message(), parent);
  std::string name = (parent / "t4d-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) return cannot(std::strerror(errno), parent);
  return TemporaryFolder(name);
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

}  // namespace t4d::system
