#include "formats/output_folder.h"

#include "formats/output_file.h"
#include "platform/replaceable.h"

namespace t4d::formats {

namespace fs = std::filesystem;

Result<void> writeInFolder(const fs::path& folder, const std::string& name,
                           std::string_view bytes) {
  const auto any = [](const fs::path&) { return true; };
  if (auto good = platform::checkReplaceable(folder, {&name, 1}, any); !good) return good;
  const fs::path path = folder / name;
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) {
    return fail(ErrorCode::Failed, "cannot make the folder: " + error.message(),
                path.parent_path().string());
  }
  return writeOutputFile(path, bytes);
}

Result<void> makeKeptFolder(const fs::path& folder) {
  constexpr const char* kMark = ".t4d-kept";
  std::error_code ignored;
  const bool isOurs = fs::symlink_status(folder / kMark, ignored).type() == fs::file_type::regular;
  if (fs::is_directory(folder, ignored) && !isOurs && !fs::is_empty(folder, ignored)) {
    return fail(ErrorCode::Failed, "the folder has other files; name another or a new one",
                folder.string());
  }
  return writeInFolder(folder, kMark, "t4d keeps files here, and may replace them.\n");
}

}  // namespace t4d::formats
