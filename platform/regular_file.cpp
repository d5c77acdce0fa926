#include "platform/regular_file.h"

#include <algorithm>

#include "platform/kept_inputs.h"

namespace t4d::platform {

namespace fs = std::filesystem;

Result<std::uint64_t> sizeOfRegularFile(const fs::path& path) {
  const auto wrong = [&](std::string message) {
    return fail(ErrorCode::Io, std::move(message), path.string());
  };
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  if (status.type() == fs::file_type::not_found) return wrong("no such file");
  if (problem) return wrong("cannot open: " + problem.message());
  if (fs::is_directory(status)) return wrong("is a folder; name a file in it");
  if (!fs::is_regular_file(status)) return wrong("is not a regular file");
  noteInput(path);
  const std::uintmax_t size = fs::file_size(path, problem);
  if (problem) return wrong("cannot read: " + problem.message());
  return size;
}

bool isWithinFolder(const fs::path& file, const fs::path& folder) {
  std::error_code problem;
  const fs::path inside = fs::canonical(file, problem);
  if (problem) return false;
  const fs::path around = fs::canonical(folder.empty() ? "." : folder, problem);
  if (problem) return false;
  return std::ranges::mismatch(around, inside).in1 == around.end();
}

}  // namespace t4d::platform
